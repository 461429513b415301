// The sections of a job file, each read by its own function. What is wrong goes to the log; the value
// returned is then only good for finding further errors.
#pragma once

#include <optional>
#include <vector>

#include "core/experiment/document.h"
#include "core/experiment/experiment.h"

namespace creep {

SpecimenSpec read_specimen(const DocumentNode& table, DiagnosticLog& log);

Material read_material(const DocumentNode& table, DiagnosticLog& log);

/// `isotropic_stress` is where loading starts [Pa]: targets rise from it. None: it starts from a checkpoint,
/// of which nothing is known yet.
std::vector<Stage> read_program(const DocumentNode& stages, std::optional<double> isotropic_stress,
                                DiagnosticLog& log);

Numerics read_numerics(const DocumentNode& table, DiagnosticLog& log);

Output read_output(const DocumentNode& table, DiagnosticLog& log);

}  // namespace creep
