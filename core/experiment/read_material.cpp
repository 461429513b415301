#include <array>
#include <limits>

#include "core/experiment/presets.h"
#include "core/experiment/sections.h"
#include "core/experiment/table_reader.h"

namespace creep {
namespace {

constexpr std::array<std::string_view, 3> kLayouts = {"octahedral", "cubic", "tetrahedral"};
constexpr std::array kLayoutValues = {SplitLayout::kOctahedral, SplitLayout::kCubic,
                                      SplitLayout::kTetrahedral};
constexpr std::array<std::string_view, 2> kRotations = {"blocked", "free"};

}  // namespace

Material read_material(const DocumentNode& table, DiagnosticLog& log) {
  TableReader reader(table, "[material]", log);
  Material material;
  if (const auto preset = reader.word("preset", material_preset_names())) material = material_preset(*preset);
  reader.quantity("shear_modulus", Dimension::kStress, 1e6, 1e12, material.shear_modulus);
  reader.number("poisson_ratio", 0.0, 0.49, material.poisson_ratio);
  reader.number("friction", 0.0, 2.0, material.friction);
  reader.quantity("density", Dimension::kDensity, 100.0, 25e3, material.density);
  reader.quantity("roughness", Dimension::kLength, 0.0, 100e-6, material.roughness);
  reader.number("roughness_n1", 0.0, 10.0, material.roughness_n1);
  reader.number("roughness_n2", 0.0, 100.0, material.roughness_n2);
  reader.number("wall_stiffness_factor", 0.1, 10.0, material.wall_stiffness_factor);
  reader.number("wall_friction", 0.0, 2.0, material.wall_friction);
  if (const auto rotation = reader.word("rotation", kRotations)) material.free_rotation = *rotation == 1;
  reader.quantity("limit_stress", Dimension::kStress, 1e6, 1e12, material.limit_stress);
  reader.quantity("reference_diameter", Dimension::kLength, 1e-6, 1.0, material.reference_diameter);
  reader.number("size_exponent", 0.0, 1.0, material.size_exponent);
  reader.number("strength_variation", 0.0, 1.0, material.strength_variation);
  reader.number("strength_floor", 0.001, 1.0, material.strength_floor);
  reader.quantity("comminution_limit", Dimension::kLength, 1e-6, 1.0, material.comminution_limit);
  if (const auto layout = reader.word("split_layout", kLayouts))
    material.split_layout = kLayoutValues[*layout];
  reader.quantity("crack_velocity", Dimension::kVelocity, 1e-9, 1e4, material.crack_velocity);
  reader.number("corrosion_index", 1.0, 200.0, material.corrosion_index);
  bool crushing = true, cracks = true;
  reader.flag("crushing", crushing);
  reader.flag("cracks", cracks);
  if (!crushing) material.comminution_limit = std::numeric_limits<double>::infinity();
  if (!cracks) material.crack_velocity = 0.0;
  reader.quantity("grading_index_max_diameter", Dimension::kLength, 1e-6, 0.1,
                  material.grading_index_max_diameter);
  reader.quantity("grading_index_min_diameter", Dimension::kLength, 1e-9, 0.1,
                  material.grading_index_min_diameter);
  reader.number("fractal_dimension", 1.0, 2.99, material.fractal_dimension);
  if (material.grading_index_min_diameter >= material.grading_index_max_diameter) {
    const bool min_given = reader.has("grading_index_min_diameter");
    reader.error(reader.position_of(min_given ? "grading_index_min_diameter" : "grading_index_max_diameter"),
                 "grading_index_min_diameter must be smaller than grading_index_max_diameter (" +
                     format_quantity(material.grading_index_min_diameter, Dimension::kLength) + " and " +
                     format_quantity(material.grading_index_max_diameter, Dimension::kLength) + ")");
  }
  reader.finish();
  return material;
}

}  // namespace creep
