#include "client/job_file/job_template.h"

#include "core/experiment/presets.h"
#include "core/experiment/wording.h"

namespace creepctl {
namespace {

constexpr std::string_view kTemplate =
    R"toml(# A creep test in quartz sand. 'creepctl validate FILE' checks it, 'creepctl run FILE --out DIR' runs it.
#
# A value with a dimension is a string with its unit. Lengths: nm, um, mm, cm, m. Stresses: Pa, kPa, MPa, GPa.
# Durations: us, ms, s, min, h, d, y. Velocities: um/s, mm/s, m/s. Densities: kg/m3, g/cm3.
# A key behind "# " shows its default: take the "# " away to change it. After it stands what is allowed.
# Compression is positive.

# name = "creep test"                    # a label, at most 200 bytes; changes no result

[specimen]
particles = 3000                         # 20 to 10000000; or side = "4 mm", the edge of the cube
grading = { preset = "fontainebleau-ne34" }
#   or grading = { points = [["0.1 mm", 0.0], ["0.4 mm", 1.0]] }: diameter, mass fraction passing from 0 to 1
#   or grading = { file = "psd.csv" }: the same in two columns, with a header like diameter_mm,passing
void_ratio = 0.65                        # after packing; 0.2 to 2; default 0.65
# isotropic_stress = "100 kPa"           # at which packing ends and strains are zero; 1 kPa to 100 MPa
# seed = 1                               # 0 and up; another seed is another specimen of the same sand

[material]
preset = "@preset@"          # or "@other@"; each key below overrides it
# Contact
# shear_modulus = "32 GPa"               # of the grains; 1 MPa to 1000 GPa
# poisson_ratio = 0.19                   # 0 to 0.49
# friction = 0.275                       # between grains; 0 to 2
# density = "2650 kg/m3"                 # of the grains; 100 to 25000 kg/m3
# roughness = "0.6 um"                   # S_q of a pair of grains; 0 (smooth) to 100 um
# roughness_n1 = 0.05                    # 0 to 10
# roughness_n2 = 5.0                     # 0 to 100
# wall_stiffness_factor = 1.0            # stiffness of a contact at a wall over one between grains; 0.1 to 10
# wall_friction = 0.0                    # between a grain and a wall, once packed; 0 to 2
# rotation = "blocked"                   # of the grains, as in the paper; or "free"
# Strength
# limit_stress = "3.75 GPa"              # mean, of a grain of the reference diameter; 1 MPa to 1000 GPa
# reference_diameter = "2 mm"            # 1 um to 1 m
# size_exponent = @size_exponent@                   # strength falls with the diameter to this power; 0 to 1
# strength_variation = 0.38              # standard deviation over mean; 0 to 1
# strength_floor = 0.05                  # least strength over mean; 0.001 to 1
# comminution_limit = "0.1155 mm"        # smaller grains never break; 1 um to 1 m
# split_layout = "octahedral"            # of the 14 fragments; or "cubic", "tetrahedral"
# Cracks
# crack_velocity = "0.1 m/s"             # at the limit stress; 0.001 um/s to 10000 m/s
# corrosion_index = 60.0                 # exponent of Charles' law; 1 to 200
# cracks = true                          # false: they do not grow
# crushing = true                        # false: no grain breaks, by cracks or otherwise
# Grading index
# grading_index_max_diameter = "0.27 mm" # coarse end of the ultimate grading; 1 um to 0.1 m
# grading_index_min_diameter = "0.01 mm" # fine end; 1 nm to 0.1 m
# fractal_dimension = 2.6                # of the ultimate grading; 1 to 2.99

[[program]]
stage = "oedometric"                     # the sides are fixed, top and bottom move
until = { axial_stress = "21.7 MPa" }    # above what was reached before; 1 kPa to 1 GPa

[[program]]
stage = "creep"                          # hold the stress and let the grains age
duration = "2 d"                         # 1 ms to 1000 y
# axial_stress = "21.7 MPa"              # default: the stress reached
#
# Other stages, in any order. After an isotropic or triaxial one the sides hold their stress:
#   stage = "isotropic"   until = { mean_stress = "10 MPa" }
#   stage = "triaxial"    until = { deviatoric_strain = 0.3 }, or axial_strain, axial_stress, deviatoric_stress,
#                         q_ratio = 0.4 with q_max = "22.6 MPa", stress_ratio = 1.2 (q/p);
#                         axial_velocity = "0.01 m/s" (closing speed), radial_stress = "10 MPa" (default: as it is)
#   stage = "unload"      until = { axial_stress = "1 MPa" }, or deviatoric_stress, mean_stress
#   stage = "relaxation"  duration = "1 d": the axial strain is held while the stress decays
# A creep stage there may have deviatoric_stress = "9 MPa", or q_ratio and q_max, instead of axial_stress.
# A stage with keep = {} keeps a named checkpoint of its end; with keep = { every_axial_strain = 0.005 } (or
# every_axial_stress, every_deviatoric_stress) of each multiple as well. Another job starts from one with [start]:
#   job = "..." and checkpoint = "02_triaxial_end"; its [specimen], [material] and [numerics] can be left out.

[numerics]
fidelity = "paper"                       # the settings of the paper; each key below overrides it
#   Or "reference", "balanced" or "fast": void ratio and creep strain wrong by at most 1.4, 4.5 and 17 % ("paper": 22 %),
#   measured on 3000 particles; "balanced" is 30.6 times, "fast" 139 times faster. Or { error = 0.1 }: the fastest as good
# minimum_cycles = 150000                # of a dynamic stage; 10 to 100000000. Most of the cost: less is a relaxation
# time_step_safety = 0.7                 # fraction of the critical step; 0.01 to 1
# breakage_fraction = 0.0026             # of the initial particles break in an ageing, at least 1; 1e-6 to 1
# breakages_per_ageing = 8               # so many instead; 1 to 1000000; or "adaptive", with
#   ageing_error_tolerance = 0.1         # on the error of the strain of a decade over that strain; 0.001 to 10
# drift_tolerance = 0.05                 # on the change of ln(end of the next ageing); 0.0001 to 10, or "none", the default
# inertial_number_limit = 1e-3           # platens slow down there in loading; 0.000001 to 0.1, or "none", the default
# settle_tolerance = 0.005               # on stress over target; 0.000001 to 0.1
# unbalanced_tolerance = 1e-4            # on unbalanced over contact force; 1e-9 to 0.1
# local_damping = 0.7                    # 0 to 0.95
# inertia_scaling = "none"               # or "fragments", "all"
# failure_check_interval = 1             # cycles; 1 to 10000
# loading_velocity = "0.1 m/s"           # closing speed of top and bottom; 1 um/s to 10 m/s
# skin = "2.1 um"                        # of the neighbour list; 1 nm to 1 cm; default: 0.01 d50; changes no result

[output]
# snapshots = "none"                     # or "per decade of age": particles and contacts for ParaView
)toml";

void replace(std::string& text, std::string_view mark, std::string_view value) {
  text.replace(text.find(mark), mark.size(), value);
}

}  // namespace

std::string job_template(std::string_view material_preset) {
  const auto names = creep::material_preset_names();
  const std::size_t index = names[0] == material_preset ? 0 : 1;
  std::string text(kTemplate);
  replace(text, "@preset@", names[index]);
  replace(text, "@other@", names[1 - index]);
  replace(text, "@size_exponent@", creep::shortest(creep::material_preset(index).size_exponent));
  return text;
}

}  // namespace creepctl
