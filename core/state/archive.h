// How values become bytes of a checkpoint, or part of a digest. A visit (layout.h) is written once for all.
#pragma once

#include <bit>
#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "core/arithmetic/digest.h"
#include "core/arithmetic/fixed_point.h"

namespace creep {

/// Appends values to a section.
class Writer {
 public:
  static constexpr bool kReading = false;
  void operator()(const double& value) { bits(std::bit_cast<std::uint64_t>(value)); }
  void operator()(const bool& value) { bits(value ? 1 : 0); }
  template <class T>
  requires std::is_integral_v<T> || std::is_enum_v<T>
  void operator()(const T& value) { bits(static_cast<std::uint64_t>(value)); }
  void operator()(const std::string& value) {
    bits(value.size());
    bytes_ += value;
  }
  void operator()(const FixedSum& sum) {
    (*this)(sum.high());
    (*this)(sum.low());
    (*this)(sum.saturated());
  }
  template <class T>
  void array(const std::vector<T>& values) {
    bits(values.size());
    for (const T& value : values) (*this)(value);
  }
  const std::string& bytes() const { return bytes_; }

 private:
  void bits(std::uint64_t value) {
    for (int i = 0; i < 8; ++i) bytes_.push_back(static_cast<char>(value >> (8 * i) & 0xffu));
  }
  std::string bytes_;
};

/// Takes values from a section; after a shortage every value is zero and ok() false, as after a value that
/// does not fit its type.
class Reader {
 public:
  static constexpr bool kReading = true;
  explicit Reader(std::string_view bytes) : bytes_(bytes) {}
  void operator()(double& value) { value = std::bit_cast<double>(bits()); }
  template <class T>
  requires std::is_integral_v<T> || std::is_enum_v<T>
  void operator()(T& value) {
    const std::uint64_t all = bits();
    value = static_cast<T>(all);
    ok_ = ok_ && static_cast<std::uint64_t>(value) == all;
  }
  void operator()(std::string& value) {
    const std::uint64_t size = bits();
    if (size > bytes_.size()) {
      ok_ = false;
      return;
    }
    value = std::string(bytes_.substr(0, size));
    bytes_.remove_prefix(size);
  }
  void operator()(FixedSum& sum) {
    std::int64_t high = 0, low = 0;
    bool saturated = false;
    (*this)(high);
    (*this)(low);
    (*this)(saturated);
    sum = FixedSum::from_halves(sum.quantum_exponent(), high, low, saturated);
  }
  template <class T>
  void array(std::vector<T>& values) {
    const std::uint64_t count = bits();
    // Every element takes at least 8 bytes, so a count beyond the section is damage, found before allocating.
    if (count > bytes_.size() / 8) {
      ok_ = false;
      return;
    }
    values.resize(count);
    for (T& value : values) (*this)(value);
  }
  /// What was read cannot be.
  void refuse() { ok_ = false; }
  bool done() const { return ok_ && bytes_.empty(); }
  bool ok() const { return ok_; }

 private:
  std::uint64_t bits() {
    if (bytes_.size() < 8) {
      ok_ = false;
      bytes_ = {};
      return 0;
    }
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < 8; ++i)
      value |= std::uint64_t{static_cast<unsigned char>(bytes_[i])} << (8 * i);
    bytes_.remove_prefix(8);
    return value;
  }
  std::string_view bytes_;
  bool ok_ = true;
};

/// Adds values to a digest.
class Digester {
 public:
  static constexpr bool kReading = false;
  void operator()(const double& value) { digest_.add(value); }
  template <class T>
  requires std::is_integral_v<T> || std::is_enum_v<T>
  void operator()(const T& value) { digest_.add(static_cast<std::uint64_t>(value)); }
  template <class T>
  void array(const std::vector<T>& values) {
    digest_.add(static_cast<std::uint64_t>(values.size()));
    for (const T& value : values) (*this)(value);
  }
  std::string hex() const { return digest_.hex(); }

 private:
  Digest digest_;
};

}  // namespace creep
