#include "core/arithmetic/digest.h"

#include <gtest/gtest.h>

namespace creep {
namespace {

TEST(Digest, is_sha_256) {
  // FIPS 180-2, appendix B.1, and the empty message.
  EXPECT_EQ(sha256_hex("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256_hex(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

TEST(Digest, takes_numbers_as_little_endian_bytes) {
  Digest numbers, bytes;
  numbers.add(std::uint64_t{0x0102030405060708});
  numbers.add(1.0);
  bytes.add(std::string_view("\x08\x07\x06\x05\x04\x03\x02\x01", 8));
  bytes.add(std::string_view("\0\0\0\0\0\0\xf0\x3f", 8));
  EXPECT_EQ(numbers.hex(), bytes.hex());
}

TEST(Digest, can_be_read_on_the_way) {
  Digest digest;
  digest.add("ab");
  EXPECT_EQ(digest.hex(), sha256_hex("ab"));
  digest.add("c");
  EXPECT_EQ(digest.hex(), sha256_hex("abc"));
}

}  // namespace
}  // namespace creep
