#!/usr/bin/env bash
# Certificates for creepd over TCP: an authority, one for the daemon on HOST (name or address, as clients write it)
# and one for each USER. What is there already stays, so further users can be added later with the same command.
#
#   deploy/certificates.sh FOLDER HOST USER...
#
# The daemon gets ca.crt, server.crt and server.key; a user gets ca.crt, USER.crt and USER.key. ca.key signs: who has
# it can make users, so keep it off both machines. A user's jobs belong to "tls:USER".
set -euo pipefail
if (($# < 2)); then
  sed -n '2,9s/^# \{0,1\}//p' "$0" >&2
  exit 2
fi
folder=$1 host=$2
shift 2
umask 077
mkdir -p "$folder"
cd "$folder"

# make_certificate NAME SUBJECT EXTENSION...: NAME.key and NAME.crt, signed by ca.key.
make_certificate() {
  local name=$1 subject=$2 extension
  shift 2
  if [[ -e "$name.crt" ]]; then
    printf '%s.crt is there already\n' "$name"
    return
  fi
  local options=()
  for extension in "$@"; do options+=(-addext "$extension"); done
  if [[ "$name" != ca ]]; then options+=(-CA ca.crt -CAkey ca.key -days 730); else options+=(-days 3650); fi
  openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -subj "/CN=$subject" \
    -keyout "$name.key" -out "$name.crt.new" "${options[@]}" 2>openssl.log || {
    cat openssl.log >&2
    exit 1
  }
  rm -f openssl.log
  mv "$name.crt.new" "$name.crt"
  printf '%s.crt and %s.key made\n' "$name" "$name"
}

make_certificate ca "creepd certificate authority" keyUsage=critical,keyCertSign,cRLSign
if [[ "$host" =~ ^[0-9.]+$ || "$host" == *:* ]]; then alternative=IP:$host; else alternative=DNS:$host; fi
make_certificate server "$host" basicConstraints=critical,CA:FALSE extendedKeyUsage=serverAuth \
  "subjectAltName=$alternative"
for user in "$@"; do
  if [[ ! "$user" =~ ^[A-Za-z0-9][A-Za-z0-9._-]*$ || "$user" == ca || "$user" == server ]]; then
    printf '%s is no name for a user\n' "$user" >&2
    exit 2
  fi
  make_certificate "$user" "$user" basicConstraints=critical,CA:FALSE extendedKeyUsage=clientAuth
done
