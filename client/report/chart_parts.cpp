#include "client/report/chart_parts.h"

#include <iterator>

namespace creepctl {

void tell_apart(Series& series, std::size_t number) {
  constexpr Hue kHues[] = {Hue::kBlue, Hue::kVermilion, Hue::kGreen, Hue::kOrange, Hue::kPurple, Hue::kSky};
  constexpr Dash kDashes[] = {Dash::kSolid, Dash::kDashed, Dash::kDotted};
  series.hue = kHues[number % std::size(kHues)];
  series.dash = kDashes[number / std::size(kHues) % std::size(kDashes)];
}

Axis creep_time_axis() { return {"creep time t (s)", Scale::kLog, {}, {}, false}; }

std::vector<Landmark> creep_time_landmarks() {
  return {{1.0, "1 s"}, {60.0, "1 min"}, {3600.0, "1 h"}, {86400.0, "1 d"}, {2592000.0, "30 d"}};
}

void add_laboratory(Chart& chart, const std::vector<LaboratoryCurve>& laboratory) {
  constexpr Marker kMarkers[] = {Marker::kSquare, Marker::kDiamond, Marker::kStar};
  for (std::size_t number = 0; number < laboratory.size(); ++number) {
    Series series{laboratory[number].name + " (laboratory)", laboratory[number].age, {}};
    for (const double strain : laboratory[number].axial_strain) series.y.push_back(100.0 * strain);
    series.hue = Hue::kBlack;
    series.stroke = false;
    series.marker = kMarkers[number % std::size(kMarkers)];
    chart.series.push_back(std::move(series));
  }
}

}  // namespace creepctl
