#include "core/dem/servo.h"

#include <algorithm>
#include <cmath>

namespace creep {

void steer(Walls& walls, const WallControl& control, double mass, double median_diameter, double step,
           ServoGains gains) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t low = 2 * axis, high = low + 1;
    double inward = 0.0, carried = 0.0;
    if (control[axis].mode == AxisControl::Mode::kServo) {
      const double cap = 0.5 * control[axis].closing_velocity;
      const double force = 0.5 * (walls.force[low] + walls.force[high]);
      const double error = control[axis].stress * walls.area(axis) - force;
      const double layer = 0.5 * (walls.stiffness[low] + walls.stiffness[high]);
      const double stiffness = layer * median_diameter / walls.length(axis);
      // Without a contact there is no stiffness to divide by: close at the cap until there is one.
      inward = stiffness > 0.0 ? error / (gains.impedances * std::sqrt(mass * stiffness))
                               : std::copysign(cap, error);
      if (control[axis].follows && stiffness > 0.0) {
        carried = walls.carried[axis];
        inward = inward + carried;
        if (std::fabs(inward) < cap)
          carried = carried + error * step / (gains.impedances * gains.periods * mass);
      }
      inward = std::clamp(inward, -cap, cap);
    } else if (control[axis].mode == AxisControl::Mode::kVelocity) {
      inward = 0.5 * control[axis].closing_velocity;
    }
    walls.carried[axis] = carried;
    walls.velocity[low] = inward;
    walls.velocity[high] = -inward;
  }
}

}  // namespace creep
