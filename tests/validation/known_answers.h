// Measured numbers beside known ones. The worst difference of each comparison becomes a row of the table in
// tests/README.md (tests/validation/table.py).
#pragma once

#include <string>

namespace creep::validation {

/// One claim, held over any number of cases; at its end it records the worst of them as a property of the
/// test.
class KnownAnswers {
 public:
  /// @param tolerance  largest difference allowed; relative where known answers are compared relatively.
  /// @param reason     why the tolerance is what it is.
  KnownAnswers(std::string claim, double tolerance, std::string reason);
  ~KnownAnswers();
  KnownAnswers(const KnownAnswers&) = delete;
  KnownAnswers& operator=(const KnownAnswers&) = delete;

  void relative(double measured, double known, const std::string& quantity);
  /// Of quantities of order 1, or that are 0.
  void absolute(double measured, double known, const std::string& quantity);

 private:
  void hold(double difference, double measured, double known, const std::string& quantity);

  std::string claim_, reason_;
  double tolerance_;
  double worst_ = 0.0;
  int cases_ = 0;
};

}  // namespace creep::validation
