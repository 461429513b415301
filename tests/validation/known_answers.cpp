#include "tests/validation/known_answers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include <nlohmann/json.hpp>

namespace creep::validation {

KnownAnswers::KnownAnswers(std::string claim, double tolerance, std::string reason)
    : claim_(std::move(claim)), reason_(std::move(reason)), tolerance_(tolerance) {}

KnownAnswers::~KnownAnswers() {
  const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
  const nlohmann::json row = {{"claim", claim_},
                              {"cases", cases_},
                              {"worst", worst_},
                              {"tolerance", tolerance_},
                              {"reason", reason_}};
  ::testing::Test::RecordProperty("known_" + std::to_string(test->result()->test_property_count()),
                                  row.dump());
}

void KnownAnswers::hold(double difference, double measured, double known, const std::string& quantity) {
  EXPECT_LE(difference, tolerance_) << quantity << ": " << measured << ", known " << known;
  // A number that is none must not pass for a small difference.
  worst_ = std::isnan(difference) ? difference : std::max(worst_, difference);
  ++cases_;
}

void KnownAnswers::relative(double measured, double known, const std::string& quantity) {
  hold(std::fabs(measured / known - 1.0), measured, known, quantity);
}

void KnownAnswers::absolute(double measured, double known, const std::string& quantity) {
  hold(std::fabs(measured - known), measured, known, quantity);
}

}  // namespace creep::validation
