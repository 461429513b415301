// Order-free sums: adding doubles in any order, by any number of threads, gives the same bits.
//
// Every addend is rounded to a multiple of a power-of-two quantum and the multiples are added as 128-bit
// integers, so addition is exactly associative. The rounding error is at most half a quantum per addend.
#pragma once

#include <cmath>
#include <cstdint>

#include "core/arithmetic/check.h"

namespace creep {

class FixedSum {
  __extension__ typedef __int128 Int128;

 public:
  /// The quantum is 2^`quantum_exponent`, in the unit of the addends; -1000 <= quantum_exponent <= 1000.
  explicit FixedSum(int quantum_exponent)
      : quantum_exponent_(quantum_exponent),
        quantum_(std::ldexp(1.0, quantum_exponent)),
        inverse_quantum_(std::ldexp(1.0, -quantum_exponent)) {
    CREEP_CHECK(quantum_exponent >= -1000 && quantum_exponent <= 1000, "quantum outside the range of double");
  }

  /// Rounds to the nearest multiple of the quantum (ties to even). An addend that is not finite or is 2^96
  /// quanta or more is left out and marks the sum as saturated; 2^31 addends below that always fit.
  void add(double addend) {
    const double quanta = addend * inverse_quantum_;  // exact: a power of two
    const double magnitude = std::fabs(quanta);
    if (!(magnitude < 0x1p96)) {
      saturated_ = true;
      return;
    }
    // From 2^52 on a double is an integer already; below, the sum with 2^52 is rounded to one.
    const double rounded = magnitude < 0x1p52 ? std::copysign((magnitude + 0x1p52) - 0x1p52, quanta) : quanta;
    sum_ += magnitude < 0x1p62 ? static_cast<Int128>(static_cast<std::int64_t>(rounded))
                               : static_cast<Int128>(rounded);
  }

  /// Adds so many quanta, as kernels count them.
  void add_quanta(std::int64_t quanta) { sum_ += quanta; }

  /// Adds a sum with the same quantum.
  void merge(const FixedSum& other) {
    CREEP_CHECK(other.quantum_exponent_ == quantum_exponent_, "sums with different quanta");
    sum_ += other.sum_;
    saturated_ = saturated_ || other.saturated_;
  }

  /// The sum, rounded once to double.
  double value() const { return static_cast<double>(sum_) * quantum_; }
  /// True if an addend was left out: the value is then wrong and must not be used.
  bool saturated() const { return saturated_; }
  int quantum_exponent() const { return quantum_exponent_; }

  /// The two halves of the 128-bit integer, for checkpoints.
  std::int64_t high() const { return static_cast<std::int64_t>(sum_ >> 64); }
  std::int64_t low() const { return static_cast<std::int64_t>(static_cast<std::uint64_t>(sum_)); }

  /// The sum whose halves are `high` and `low`.
  static FixedSum from_halves(int quantum_exponent, std::int64_t high, std::int64_t low,
                              bool saturated = false) {
    FixedSum sum(quantum_exponent);
    sum.sum_ = (static_cast<Int128>(high) * (static_cast<Int128>(1) << 64)) + static_cast<std::uint64_t>(low);
    sum.saturated_ = saturated;
    return sum;
  }

 private:
  Int128 sum_ = 0;
  int quantum_exponent_;
  double quantum_;
  double inverse_quantum_;
  bool saturated_ = false;
};

}  // namespace creep
