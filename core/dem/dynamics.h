// The dynamic computation: one cycle = contact forces, resultants, kick, drift, walls, clocks.
//
// The plot of a cycle n: forces at x_n from overlaps and from the shear that velocities v_{n-1/2} brought;
// kick to v_{n+1/2}; drift to x_{n+1}; walls likewise by the servo. Nothing here breaks a particle: a cycle
// reports which have failed, the splitter replaces them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/dem/activity.h"
#include "core/dem/contact_model.h"
#include "core/dem/contact_search.h"
#include "core/dem/kernels.h"
#include "core/dem/servo.h"
#include "core/dem/specimen.h"
#include "core/dem/team.h"
#include "core/experiment/experiment.h"

namespace creep {

enum class FailureCause : std::uint8_t { kImmediate = 0, kCrackInDynamicStage = 1, kCrackInAgeing = 2 };

struct Failure {
  std::int32_t index = 0;  ///< of the particle
  FailureCause cause = FailureCause::kImmediate;
  double stress_ratio = 0.0;  ///< sigma_mob / sigma_lim
};

/// What a cycle found; empty and false almost always.
struct CycleResult {
  std::vector<Failure> failures;  ///< ascending index, each particle once
  bool finite = true;
  double largest_overlap_ratio = 0.0;  ///< over the smaller radius; 0 in cycles that do not measure
  double step_ratio =
      0.0;  ///< step over the bound sqrt2 min sqrt(m/lambda_max); 0 in cycles that do not measure
};

class Dynamics {
 public:
  /// Cycles between measurements of contact stresses, by which cracks grow (README, "Cracks"), and between
  /// evaluations of the time step.
  static constexpr std::int64_t kMeasureInterval = 10;
  static constexpr std::int64_t kTimeStepInterval = 50;

  struct Options {
    int threads = 1;
    std::int64_t rebuild_every = 0;    ///< force a search every so many cycles; 0: when due
    ActivityMark* activity = nullptr;  ///< where to mark what is being done
  };

  Dynamics(const Experiment& experiment, const Kernels& kernels, Options options);

  /// Whether failures and crack growth are looked at (not while packing).
  void let_fail(bool on) { may_fail_ = on; }

  /// One cycle.
  CycleResult cycle(Specimen& specimen, const WallControl& control);

  /// Forces, contact stresses and the stable time step of the specimen as it stands; nothing moves. Needed
  /// after anything but a cycle changed it.
  void assess(Specimen& specimen);

  /// Search after a split. @param new_index  as in ContactSearch::search.
  void relist(Specimen& specimen, const std::vector<std::int32_t>& new_index);
  /// Search if the list is not valid.
  void ensure_list(Specimen& specimen);

  const ContactModel& model() const { return model_; }
  std::int64_t searches() const { return search_.searches(); }

 private:
  struct Sums {
    ContactSums contacts;
    ParticleSums particles;
  };
  Sums compute(Specimen& specimen, CycleKind kind, double kick, double drift, CycleResult& result);
  void turn_particles(Specimen& specimen, double kick);
  void book(Specimen& specimen, const Sums& sums, CycleKind kind) const;
  void move_walls(Specimen& specimen, const WallControl& control, double drift) const;
  void advance_clocks(Specimen& specimen, double drift) const;
  void grow_cracks(Specimen& specimen, CycleResult& result);
  void find_failures_in_contacts(const Specimen& specimen, std::vector<Failure>& failures) const;
  void find_failures_at_walls(std::vector<Failure>& failures);
  double stable_step(double largest_stiffness_over_mass) const;

  const Experiment& experiment_;
  const Kernels& kernels_;
  Options options_;
  ContactModel model_;
  ContactSearch search_;
  Team team_;
  double median_diameter_;
  bool crushable_;              ///< some particle may fail
  double least_growing_ratio_;  ///< stress ratio below which no crack grows measurably
  bool may_fail_ = false;
  std::vector<double> breaking_at_walls_;  ///< n: stress ratio of a particle that breaks there, else 0
  std::vector<Sums> of_member_;
  std::vector<std::vector<Failure>> grown_through_;  ///< a thread each
};

}  // namespace creep
