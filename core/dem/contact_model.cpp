#include "core/dem/contact_model.h"

#include <algorithm>
#include <cmath>

namespace creep {

ContactModel::ContactModel(const Material& material)
    : law(RoughLaw::make(material.roughness, material.roughness_n1, material.roughness_n2)),
      table(law),
      modulus(material.reduced_modulus()),
      wall_modulus(material.reduced_modulus() * material.wall_stiffness_factor),
      tangential_ratio(material.tangential_ratio()),
      // A tenth of the roughness, or for smooth grains a force far below any that matters.
      least_overlap(std::max(0.1 * material.roughness, 1e-9)) {}

LawView ContactModel::view() const {
  LawView view;
  view.cells = law.delta_T2() > 0.0 ? table.cells() : nullptr;
  view.inverse_delta_T1 = table.inverse_delta_T1();
  view.delta_T2 = table.delta_T2();
  view.hertz_offset = table.hertz_offset();
  view.before_first_cell = table.before_first_cell();
  view.cell_shift = table.cell_shift();
  view.base_mask = static_cast<std::int64_t>(table.base_mask());
  return view;
}

ContactModel::Normal ContactModel::between(const Body& first, const Body& second, double root_radius) const {
  const double dx = second.x - first.x, dy = second.y - first.y, dz = second.z - first.z;
  const double distance = std::sqrt(std::fma(dx, dx, std::fma(dy, dy, dz * dz)));
  Normal normal;
  normal.overlap = (first.radius + second.radius) - distance;
  if (!(normal.overlap > 0.0)) return normal;
  double g = 0.0, slope = 0.0;
  table.evaluate(normal.overlap, g, slope);
  const double prefactor = modulus * root_radius;
  normal.force = prefactor * g;
  normal.stiffness = prefactor * slope;
  return normal;
}

ContactModel::Normal ContactModel::at_wall(const Body& body, double gap) const {
  Normal normal;
  normal.overlap = body.radius - gap;
  if (!(normal.overlap > 0.0)) return normal;
  double g = 0.0, slope = 0.0;
  table.evaluate(normal.overlap, g, slope);
  const double prefactor = wall_modulus * std::sqrt(body.radius);
  normal.force = prefactor * g;
  normal.stiffness = prefactor * slope;
  return normal;
}

}  // namespace creep
