#include "tests/fuzz/target.h"

#include <algorithm>

// libFuzzer calls the first two and offers the third; the names are its own.
extern "C" {
int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most, unsigned seed);
std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most);
}

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  creep::fuzz::try_input({reinterpret_cast<const char*>(data), size});
  return 0;
}

std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most, unsigned seed) {
  creep::fuzz::Random random(seed);
  const std::string out = creep::fuzz::altered({reinterpret_cast<const char*>(data), size}, random);
  if (out.size() > most) return LLVMFuzzerMutate(data, size, most);
  std::copy(out.begin(), out.end(), data);
  return out.size();
}

namespace creep::fuzz {

std::string mutated(std::string_view bytes, std::size_t most) {
  std::vector<std::uint8_t> room(bytes.begin(), bytes.end());
  room.resize(std::max(most, bytes.size()));
  room.resize(LLVMFuzzerMutate(room.data(), bytes.size(), room.size()));
  return {room.begin(), room.end()};
}

std::uint64_t awkward_number(Random& random) {
  constexpr std::uint64_t kOne = 1;
  switch (random() % 8) {
    case 0:
      return 0;
    case 1:
      return random() % 4;
    case 2:
      return ~std::uint64_t{0} - random() % 4;
    case 3:
      return 0x7FF8000000000000u;  // not a number
    case 4:
      return 0x7FF0000000000000u;  // infinity
    case 5:
      return kOne << (random() % 64);
    case 6:
      return (kOne << (random() % 64)) - 1;
    default:
      return random();
  }
}

void put_number(std::string& bytes, std::size_t at, std::uint64_t value) {
  for (std::size_t i = 0; i < 8; ++i) bytes[at + i] = static_cast<char>(value >> (8 * i) & 0xFFu);
}

void put_awkward_number(std::string& bytes, Random& random) {
  put_number(bytes, random() % (bytes.size() / 8) * 8, awkward_number(random));
}

}  // namespace creep::fuzz
