// SHA-256 of bytes and numbers: of the state, of an experiment, of a checkpoint's sections.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

struct evp_md_ctx_st;

namespace creep {

class Digest {
 public:
  Digest();

  /// The bytes alone; where two strings follow each other the caller adds their lengths.
  void add(std::string_view bytes);
  /// The 8 bytes of the IEEE 754 representation, little endian; 0.0 and -0.0 differ.
  void add(double value);
  /// 8 bytes, little endian.
  void add(std::uint64_t value);

  /// 64 lower-case hex digits of what was added up to here; adding may go on.
  std::string hex() const;

 private:
  struct Free {
    void operator()(evp_md_ctx_st* context) const;
  };
  std::unique_ptr<evp_md_ctx_st, Free> context_;
};

/// SHA-256 of the bytes as 64 lower-case hex digits.
std::string sha256_hex(std::string_view bytes);

}  // namespace creep
