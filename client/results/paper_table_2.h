// The paper's triaxial creep tests, and which of them a job is a trial of.
#pragma once

#include <array>
#include <optional>

#include "client/results/hold.h"
#include "client/results/job_results.h"

namespace creepctl {

/// Lei, Arroyo, Ciantia & Zhang, Table 2: creep at 10 MPa of lateral stress and a share of q_max.
struct TriaxialCreepTest {
  double stress_ratio = 0.0;  ///< q / q_max [-]
  double m = 0.0;             ///< Singh-Mitchell slope of primary creep [-]
  double rate_10_min = 0.0;   ///< axial strain rate at 10 min [%/min]
};

inline constexpr double kPaperDeviatoricStrength = 22.6e6;  ///< q_max [Pa]
inline constexpr double kPaperRadialStress = 10e6;          ///< [Pa]
inline constexpr std::array<TriaxialCreepTest, 10> kPaperTriaxialCreep = {{{0.2, 0.7713, 0.00043},
                                                                           {0.3, 0.7356, 0.001},
                                                                           {0.4, 0.7903, 0.0017},
                                                                           {0.5, 0.7484, 0.0038},
                                                                           {0.6, 0.7353, 0.0086},
                                                                           {0.7, 0.7246, 0.0263},
                                                                           {0.75, 0.7360, 0.0558},
                                                                           {0.8, 0.7238, 0.1247},
                                                                           {0.85, 0.723, 0.30},
                                                                           {0.9, 0.7251, 0.855}}};

/// The test at the mean stresses of the hold: lateral stress and q/q_max within 2 % of the paper's.
std::optional<TriaxialCreepTest> paper_triaxial_creep(const JobResults& results, const Hold& hold);

}  // namespace creepctl
