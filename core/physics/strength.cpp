#include "core/physics/strength.h"

#include <algorithm>

#include "core/arithmetic/elementary.h"

namespace creep {

double limit_stress(const Material& material, double diameter, double standard_normal) {
  const double size_effect = elementary::pow(diameter / material.reference_diameter, -material.size_exponent);
  const double scatter =
      std::max(material.strength_floor, 1.0 + material.strength_variation * standard_normal);
  return material.limit_stress * size_effect * scatter;
}

}  // namespace creep
