#!/usr/bin/env bash
# What somebody else wrote into a job file must not speak to the terminal that shows it, nor turn its writing round.
system=$(dirname "${BASH_SOURCE[0]}")/../system
source "$system/support.sh"

# quiet: nothing that a terminal obeys is in the output, but line ends; bytes that are no UTF-8 are not either.
quiet() {
  LC_ALL=C.UTF-8 /usr/bin/python3 - "$work/output" <<'PYTHON' || fail "the output speaks to the terminal"
import sys, unicodedata
text = open(sys.argv[1], encoding="utf-8").read()  # fails on what is no UTF-8
bad = [hex(ord(c)) for c in text if c != "\n" and unicodedata.category(c) in ("Cc", "Cf", "Zl", "Zp")]
sys.exit(f"there are {bad}" if bad else 0)
PYTHON
}

for code in 001B 0007 007F 009B 200E 202E 2066 2028 061C; do
  printf 'name = "a\\u%sb"\n' "$code" | cat - "$job" >"$work/named.toml"
  expect_exit 5 "$bin/creepctl" validate "$work/named.toml"
  expect_output "without control characters"
  quiet
  # Quoted in a diagnostic.
  { cat "$job"; printf '"k\\u%sey" = 1\n' "$code"; } >"$work/key.toml"
  expect_exit 5 "$bin/creepctl" validate "$work/key.toml"
  quiet
done
printf 'name = "höher, 高い, עברית"\n' | cat - "$job" >"$work/named.toml"
expect_exit 0 "$bin/creepctl" validate "$work/named.toml"
