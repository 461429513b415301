#include "core/analysis/thinning.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace creep {
namespace {

constexpr double kUpToZero = -std::numeric_limits<double>::infinity();
constexpr double kNoNumber = std::numeric_limits<double>::infinity();

void put(ThinnedRow& row, std::uint64_t index, std::span<const double> values) {
  row.index = index;
  row.values.assign(values.begin(), values.end());
}

}  // namespace

Thinner::Thinner(Buckets buckets, std::size_t columns)
    : buckets_(buckets), least_(columns), greatest_(columns) {}

double Thinner::bucket_of(double by) const {
  if (std::isnan(by)) return kNoNumber;
  if (buckets_.width > 0.0) return std::floor(by / buckets_.width);
  return by > 0.0 ? std::floor(std::log10(by) * buckets_.per_decade) : kUpToZero;
}

void Thinner::add(std::uint64_t index, double by, std::span<const double> values) {
  const double bucket = bucket_of(by);
  if (open_ && bucket != bucket_) end_bucket();
  if (!open_) {
    open_ = true;
    bucket_ = bucket;
    put(first_, index, values);
  }
  put(last_, index, values);
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isnan(values[i])) continue;
    if (least_[i].values.empty() || values[i] < least_[i].values[i]) put(least_[i], index, values);
    if (greatest_[i].values.empty() || values[i] > greatest_[i].values[i]) put(greatest_[i], index, values);
  }
}

void Thinner::end_bucket() {
  if (!open_) return;
  open_ = false;
  std::vector<const ThinnedRow*> stay = {&first_, &last_};
  for (const auto* extremes : {&least_, &greatest_}) {
    for (const ThinnedRow& row : *extremes) {
      if (!row.values.empty()) stay.push_back(&row);
    }
  }
  std::sort(stay.begin(), stay.end(),
            [](const ThinnedRow* a, const ThinnedRow* b) { return a->index < b->index; });
  const auto same = [](const ThinnedRow* a, const ThinnedRow* b) { return a->index == b->index; };
  stay.erase(std::unique(stay.begin(), stay.end(), same), stay.end());
  for (const ThinnedRow* row : stay) rows_.push_back(*row);
  for (auto* extremes : {&least_, &greatest_}) {
    for (ThinnedRow& row : *extremes) row.values.clear();
  }
}

}  // namespace creep
