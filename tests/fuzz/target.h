// What a fuzzed subject brings: how one input is tried, how inputs are altered, and inputs to start from.
//
// Each is linked twice: with libFuzzer (CREEP_FUZZ, clang) and with replay.cpp (every build).
#pragma once

#include <cstddef>
#include <cstdint>
#include <random>
#include <string>
#include <string_view>
#include <vector>

namespace creep::fuzz {

using Random = std::minstd_rand;

/// Aborts if the input breaks a promise.
void try_input(std::string_view bytes);

/// An input altered in its own format, so that lengths and checksums stay right.
std::string altered(std::string_view bytes, Random& random);

/// Small inputs that are sound.
std::vector<std::string> seeds();

// For the subjects:

/// Bytes altered at random, or as coverage suggests; at most `most` of them.
std::string mutated(std::string_view bytes, std::size_t most);

/// Numbers at which code goes wrong.
std::uint64_t awkward_number(Random& random);

/// Little-endian.
void put_number(std::string& bytes, std::size_t at, std::uint64_t value);

/// Replaces one eight-byte number of the bytes; they must hold one.
void put_awkward_number(std::string& bytes, Random& random);

}  // namespace creep::fuzz
