#include "core/experiment/presets.h"

#include <array>

#include "core/arithmetic/check.h"

namespace creep {
namespace {

constexpr std::array<std::string_view, 2> kMaterials = {"fontainebleau-ne34", "fontainebleau-ne34-literal"};
constexpr std::array<std::string_view, 1> kGradings = {"fontainebleau-ne34"};

}  // namespace

std::span<const std::string_view> material_preset_names() { return kMaterials; }

Material material_preset(std::size_t index) {
  CREEP_CHECK(index < kMaterials.size(), "a preset that is not there");
  Material material;  // the defaults of the struct are the first preset: Table 1 of the paper, k = 3/m_p
  material.preset = std::string(kMaterials[index]);
  if (index == 1) material.size_exponent = 1.0 / 12.0;  // eq 11 as printed: k = 1/m_p
  return material;
}

std::span<const std::string_view> grading_preset_names() { return kGradings; }

Grading grading_preset(std::size_t index) {
  CREEP_CHECK(index < kGradings.size(), "a preset that is not there");
  return LognormalGrading{};
}

}  // namespace creep
