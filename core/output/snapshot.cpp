#include "core/output/snapshot.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/escaping.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "core/dem/measures.h"
#include "core/experiment/wording.h"
#include "core/output/samples.h"

namespace creep {
namespace {

/// A contact counts as sliding from this share of its Coulomb limit on: shear forces are those of the
/// positions one step before, so that one which slides is found a little off its limit.
constexpr double kSlidingShare = 0.999;

/// One DataArray: 8-byte little-endian numbers.
class Column {
 public:
  static Column of_doubles(const char* name, int components = 1) { return {"Float64", name, components}; }
  static Column of_integers(const char* name) { return {"Int64", name, 1}; }

  void add(double value) { append(bytes_, std::bit_cast<std::uint64_t>(value)); }
  void add(std::int64_t value) { append(bytes_, static_cast<std::uint64_t>(value)); }

  /// The bytes behind their number, in base64.
  std::string element() const {
    std::string all;
    append(all, bytes_.size());
    all += bytes_;
    return absl::StrCat("<DataArray type=\"", type_, "\" Name=\"", name_, "\" NumberOfComponents=\"",
                        components_, "\" format=\"binary\">", absl::Base64Escape(all), "</DataArray>\n");
  }

 private:
  Column(const char* type, const char* name, int components)
      : type_(type), name_(name), components_(components) {}

  static void append(std::string& bytes, std::uint64_t value) {
    for (int i = 0; i < 8; ++i) bytes.push_back(static_cast<char>(value >> (8 * i) & 0xffu));
  }

  const char* type_;
  const char* name_;
  int components_;
  std::string bytes_;
};

std::string elements(const std::vector<Column>& columns) {
  std::string text;
  for (const Column& column : columns) text += column.element();
  return text;
}

std::string number_element(std::string_view type, std::string_view name, std::string_view value) {
  return absl::StrCat("<DataArray type=\"", std::string(type), "\" Name=\"", std::string(name),
                      "\" NumberOfTuples=\"1\" format=\"ascii\">", std::string(value), "</DataArray>\n");
}

/// TimeValue is what viewers take for the time of a file.
std::string field_data(const SnapshotHead& head) {
  return absl::StrCat(
      "<FieldData>\n", number_element("Float64", "TimeValue", shortest(head.age + head.dynamic_time)),
      number_element("Float64", "age_s", shortest(head.age)),
      number_element("Float64", "dynamic_time_s", shortest(head.dynamic_time)),
      number_element("Float64", "creep_time_s", shortest(head.creep_time)),
      number_element("Int64", "next_sequence", absl::StrCat(head.next_sequence)), "</FieldData>\n");
}

/// Connectivity and offsets of cells with `nodes` points each.
struct Cells {
  explicit Cells(std::int64_t nodes) : nodes(nodes) {}
  void add(std::initializer_list<std::int64_t> points) {
    for (const std::int64_t point : points) connectivity.add(point);
    offsets.add(nodes * ++count);
  }
  std::string text() const { return connectivity.element() + offsets.element(); }

  std::int64_t nodes;
  std::int64_t count = 0;
  Column connectivity = Column::of_integers("connectivity");
  Column offsets = Column::of_integers("offsets");
};

struct Drawing {
  std::vector<Column> of_points, of_cells;
  Cells points{1}, lines{2};
};

std::string poly_data(const SnapshotHead& head, const Particles& particles, const Drawing& drawing) {
  Column centre = Column::of_doubles("Points", 3);
  for (const Body& body : particles.body) {
    for (const double coordinate : {body.x, body.y, body.z}) centre.add(coordinate);
  }
  std::string text =
      "<?xml version=\"1.0\"?>\n"
      "<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n"
      "<PolyData>\n";
  text += field_data(head);
  absl::StrAppend(&text, "<Piece NumberOfPoints=\"", particles.size(), "\" NumberOfVerts=\"",
                  drawing.points.count, "\" NumberOfLines=\"", drawing.lines.count,
                  "\" NumberOfStrips=\"0\" NumberOfPolys=\"0\">\n");
  text += "<PointData>\n" + elements(drawing.of_points) + "</PointData>\n";
  text += "<CellData>\n" + elements(drawing.of_cells) + "</CellData>\n";
  text += "<Points>\n" + centre.element() + "</Points>\n";
  text += "<Verts>\n" + drawing.points.text() + "</Verts>\n";
  text += "<Lines>\n" + drawing.lines.text() + "</Lines>\n";
  return text + "</Piece>\n</PolyData>\n</VTKFile>\n";
}

Drawing draw_particles(const Specimen& specimen, const ContactModel& model) {
  const Particles& particles = specimen.particles;
  const std::vector<double> stress = mobilised_stress(specimen, model);
  Column id = Column::of_integers("id"), parent = Column::of_integers("parent"),
         generation = Column::of_integers("generation"), radius = Column::of_doubles("radius"),
         diameter = Column::of_doubles("diameter_mm"), velocity = Column::of_doubles("velocity", 3),
         mobilised = Column::of_doubles("mobilised_stress_Pa"), limit = Column::of_doubles("limit_stress_Pa"),
         ratio = Column::of_doubles("stress_ratio"), crack = Column::of_doubles("crack_ratio");
  Drawing drawing;
  for (std::size_t i = 0; i < particles.size(); ++i) {
    const Body& body = particles.body[i];
    drawing.points.add({static_cast<std::int64_t>(i)});
    id.add(static_cast<std::int64_t>(particles.id[i]));
    parent.add(static_cast<std::int64_t>(particles.parent[i]));
    generation.add(static_cast<std::int64_t>(particles.generation[i]));
    radius.add(body.radius);
    diameter.add(2e3 * body.radius);
    for (const double component : {body.vx, body.vy, body.vz}) velocity.add(component);
    mobilised.add(stress[i]);
    limit.add(particles.limit_stress[i]);
    ratio.add(stress[i] / particles.limit_stress[i]);
    crack.add(particles.crack[i] / body.radius);
  }
  drawing.of_points = {id, parent, generation, radius, diameter, velocity, mobilised, limit, ratio, crack};
  return drawing;
}

/// Shear force in the present tangent plane [N], before Coulomb.
double turned_shear(const Contacts& contacts, std::size_t c, const Body& a, const Body& b) {
  const double shear[3] = {contacts.shear_x[c], contacts.shear_y[c], contacts.shear_z[c]};
  const double branch[3] = {b.x - a.x, b.y - a.y, b.z - a.z};
  const double squared = branch[0] * branch[0] + branch[1] * branch[1] + branch[2] * branch[2];
  const double along = (shear[0] * branch[0] + shear[1] * branch[1] + shear[2] * branch[2]) / squared;
  double tangential = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double component = shear[axis] - along * branch[axis];
    tangential += component * component;
  }
  return std::sqrt(tangential);
}

Drawing draw_contacts(const Specimen& specimen, const ContactModel& model) {
  const Contacts& contacts = specimen.contacts;
  Column normal_force = Column::of_doubles("normal_force_N"),
         shear_force = Column::of_doubles("shear_force_N"), sliding = Column::of_integers("sliding"),
         overlap = Column::of_doubles("overlap_m");
  Drawing drawing;
  for (std::size_t c = 0; c < contacts.count; ++c) {
    const Body& a = specimen.particles.body[static_cast<std::size_t>(contacts.first[c])];
    const Body& b = specimen.particles.body[static_cast<std::size_t>(contacts.second[c])];
    const ContactModel::Normal normal = model.between(a, b, contacts.root_radius[c]);
    if (!(normal.overlap > 0.0)) continue;
    const double shear = turned_shear(contacts, c, a, b);
    const double coulomb = specimen.friction * normal.force;
    drawing.lines.add({contacts.first[c], contacts.second[c]});
    normal_force.add(normal.force);
    shear_force.add(std::min(shear, coulomb));
    sliding.add(std::int64_t{shear > 0.0 && shear >= kSlidingShare * coulomb});
    overlap.add(normal.overlap);
  }
  drawing.of_cells = {normal_force, shear_force, sliding, overlap};
  return drawing;
}

/// "00_packing", "01_oedometric", "02_creep_0004": in the order of the run when sorted.
std::string label(const RunState& state, const Experiment& experiment) {
  const absl::Dec place(state.stage + 1, absl::kZeroPad2);
  if (state.stage < 0) {
    return absl::StrCat(place, std::holds_alternative<Starting>(state.act) ? "_start" : "_packing");
  }
  const Stage& stage = experiment.program[static_cast<std::size_t>(state.stage)];
  const std::string name(stage_name(stage));
  if (target_of(stage) != nullptr) return absl::StrCat(place, "_", name);
  return absl::StrCat(place, "_", name, "_", absl::Dec(dynamic_stage_number(state), absl::kZeroPad4));
}

/// The text of the element with this name among the first lines; empty if there is none.
std::string_view number_text(std::string_view head, std::string_view name) {
  const std::size_t at = head.find(absl::StrCat("Name=\"", std::string(name), "\""));
  if (at == std::string_view::npos) return {};
  const std::size_t begin = head.find('>', at);
  const std::size_t end = head.find('<', at);
  if (begin >= end || end == std::string_view::npos) return {};
  return head.substr(begin + 1, end - begin - 1);
}

}  // namespace

std::vector<Snapshot> snapshots(const RunState& state, const Experiment& experiment,
                                const ContactModel& model) {
  const Specimen& specimen = state.specimen;
  const SnapshotHead head{specimen.clocks.age, specimen.clocks.dynamic_time, creep_time(state),
                          state.next_sequence};
  const std::string suffix = absl::StrCat("_", label(state, experiment), ".vtp");
  return {{"particles" + suffix, head, poly_data(head, specimen.particles, draw_particles(specimen, model))},
          {"contacts" + suffix, head, poly_data(head, specimen.particles, draw_contacts(specimen, model))}};
}

absl::StatusOr<SnapshotHead> read_snapshot_head(std::string_view bytes) {
  constexpr std::size_t kFirstLines = 2048;  // the longest head has well under 1 kB
  const std::string_view lines = bytes.substr(0, kFirstLines);
  SnapshotHead head;
  const std::pair<const char*, double*> numbers[] = {
      {"age_s", &head.age}, {"dynamic_time_s", &head.dynamic_time}, {"creep_time_s", &head.creep_time}};
  bool whole = absl::SimpleAtoi(std::string(number_text(lines, "next_sequence")), &head.next_sequence);
  for (const auto& [name, value] : numbers) {
    whole = whole && absl::SimpleAtod(std::string(number_text(lines, name)), value);
  }
  if (!whole) return absl::DataLossError("not a snapshot: its first lines do not say when it was taken");
  return head;
}

}  // namespace creep
