// Tries a subject without libFuzzer: its seeds, alterations of them, and every file given.
//
//   X_replay FILE|FOLDER...         aborts at the first input that breaks a promise, with its name on stderr
//   X_replay --write-seeds FOLDER   writes the seeds, to fuzz from
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "tests/fuzz/target.h"

namespace {

namespace fs = std::filesystem;

constexpr int kAlterations = 50;  // of each seed

std::size_t tried = 0;

void replay(const std::string& name, std::string_view bytes) {
  std::fprintf(stderr, "%s\n", name.c_str());
  creep::fuzz::try_input(bytes);
  ++tried;
}

void try_file(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream bytes;
  bytes << file.rdbuf();
  replay(path.string(), bytes.str());
}

void try_seeds() {
  creep::fuzz::Random random(1);
  const std::vector<std::string> seeds = creep::fuzz::seeds();
  for (std::size_t s = 0; s < seeds.size(); ++s) {
    std::string bytes = seeds[s];
    replay("seed " + std::to_string(s), bytes);
    for (int a = 1; a <= kAlterations; ++a) {
      // Each alteration on top of the last, so that some go far.
      bytes = creep::fuzz::altered(bytes, random);
      replay("seed " + std::to_string(s) + " altered " + std::to_string(a) + " times", bytes);
    }
  }
}

void write_seeds(const fs::path& folder) {
  fs::create_directories(folder);
  const std::vector<std::string> seeds = creep::fuzz::seeds();
  for (std::size_t s = 0; s < seeds.size(); ++s) {
    std::ofstream(folder / ("seed-" + std::to_string(s)), std::ios::binary) << seeds[s];
  }
}

}  // namespace

// In libFuzzer's place.
extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most) {
  static std::mt19937_64 engine(1);
  const std::uint64_t dice = engine();
  const auto byte = static_cast<std::uint8_t>(dice >> 8);
  if (size < most && (size == 0 || dice % 4 == 0)) {
    data[size] = byte;
    return size + 1;
  }
  if (size == 0) return 0;
  const std::size_t at = (dice >> 16) % size;
  if (dice % 4 == 1) {
    std::memmove(data + at, data + at + 1, size - at - 1);
    return size - 1;
  }
  data[at] = byte;
  return size;
}

int main(int count, char** words) {
  if (count == 3 && std::strcmp(words[1], "--write-seeds") == 0) {
    write_seeds(words[2]);
    return 0;
  }
  try_seeds();
  for (int w = 1; w < count; ++w) {
    if (!fs::is_directory(words[w])) {
      try_file(words[w]);
      continue;
    }
    for (const auto& entry : fs::recursive_directory_iterator(words[w])) {
      if (entry.is_regular_file()) try_file(entry.path());
    }
  }
  std::printf("%zu inputs\n", tried);
  return 0;
}
