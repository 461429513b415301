"""What a job directory says: figures of its summary and tables, and the creep analysis as its report prints it."""
import csv
import html
import json
import re
import subprocess

STOPPED = "runs_away.txt"  # why the study stopped a run
PER_CENT = 100.0

# Columns of runs.csv: name, unit, meaning. The order is that of the file.
COLUMNS = {
    "e0": "void ratio after packing",
    "generation_friction": "friction while packing",
    "e_loaded": "void ratio at the end of loading",
    "e_rest": "void ratio after the initial dynamic stage",
    "broken_loading_percent": "particles broken before the hold, of the initial ones",
    "jumps": "ageing jumps, the closing one included",
    "creep_strain_percent": "axial strain of the hold",
    "contraction_percent": "volumetric strain of the hold",
    "grading_index_change": "I_G at the end of the hold, less I_G at its beginning",
    "ripple_percent": "largest deviation of the stress from its target after the initial dynamic stage",
    "m": "Singh-Mitchell slope of primary creep",
    "rate_10_min_percent_per_min": "axial strain rate at 10 min, of that fit",
    "q_max_MPa": "largest deviatoric stress of shear",
    "strain_at_q_max_percent": "axial strain there",
    "radial_stress_at_q_max_MPa": "lateral stress there: how far the servo lags",
    "energy_unexplained": "of the wall work",
}


def table(path):
    if not path.exists():
        return []
    with open(path) as file:
        return [{name: float(value) for name, value in row.items() if value} for row in csv.DictReader(file)]


def verdict(folder):
    path = folder / "verdict.json"
    return json.loads(path.read_text()) if path.exists() else {}


def status(folder):
    """How far a run is: "not begun", "cut short", "runs away", or its outcome."""
    if (folder / STOPPED).exists():
        return "runs away"
    outcome = verdict(folder).get("outcome", "")
    if outcome in ("", "checkpointed", "io_error"):
        return "cut short" if folder.exists() else "not begun"
    return outcome.replace("_", " ")


def is_done(folder):
    return status(folder) not in ("not begun", "cut short")


def report(folder, bin_folder):
    """Label -> text of the table of the creep analysis, which creepctl alone computes."""
    subprocess.run([bin_folder / "creepctl", "report", folder], check=True, stdout=subprocess.DEVNULL)
    page = (folder / "report.html").read_text()
    rows = re.findall(r"<tr><td>(.*?)</td><td>(.*?)</td></tr>", page)
    return {html.unescape(label): html.unescape(text) for label, text in rows}


def leading_number(text):
    found = re.match(r"-?\d[\d.]*(e[-+]?\d+)?", text or "")
    return float(found.group()) if found else None


def hold_of(row, folder):
    """Figures of the last hold; from the tables, so that a run that was stopped has them too."""
    stages = table(folder / "stages.csv")
    holds = [stage for stage in stages if stage["dynamic_stage"] >= 0]
    loadings = [stage for stage in stages if stage["dynamic_stage"] < 0]
    if loadings:
        row["e_loaded"] = loadings[-1]["void_ratio_end"]
    if not holds:
        return
    row["e_rest"] = holds[0]["void_ratio_end"]
    row["jumps"] = len(holds) - 1
    samples = table(folder / "samples.csv")
    inside = [sample for sample in samples if sample["phase"] >= 2]
    before = [sample for sample in samples if sample["phase"] == 1]
    first, last = (before or inside)[-1 if before else 0], inside[-1]
    row["creep_strain_percent"] = PER_CENT * (last["axial_strain"] - first["axial_strain"])
    row["contraction_percent"] = PER_CENT * (last["volumetric_strain"] - first["volumetric_strain"])
    row["grading_index_change"] = last["grading_index"] - first["grading_index"]
    row["broken_loading"] = first["broken_total"]
    if len(holds) > 1:
        row["ripple_percent"] = PER_CENT * max(stage["ripple"] for stage in holds[1:])


def shear_of(row, folder):
    shear = [sample for sample in table(folder / "samples.csv") if sample["phase"] == 1 and sample["stage"] == 1]
    peak = max(shear, key=lambda sample: sample["deviatoric_stress_Pa"], default=None)
    if peak is None:
        return
    row["q_max_MPa"] = 1e-6 * peak["deviatoric_stress_Pa"]
    row["strain_at_q_max_percent"] = PER_CENT * peak["axial_strain"]
    row["radial_stress_at_q_max_MPa"] = 1e-6 * peak["radial_stress_Pa"]


def of_run(name, folder, bin_folder):
    row = {"run": name, "outcome": status(folder)}
    samples = table(folder / "samples.csv")
    summary_path = folder / "summary.json"
    figures = json.loads(summary_path.read_text())["figures"] if summary_path.exists() else {}
    row["e0"] = figures.get("void_ratio_reached")
    row["generation_friction"] = figures.get("generation_friction")
    packing = [sample for sample in samples if sample["phase"] == 0]
    if row["e0"] is None and packing:
        row["e0"] = packing[-1]["void_ratio"]
    shear_of(row, folder) if name.startswith("sheared/") else hold_of(row, folder)
    if packing and "broken_loading" in row:
        row["broken_loading_percent"] = PER_CENT * row["broken_loading"] / packing[-1]["particles"]
    if samples and samples[-1]["wall_work_J"] > 0:
        row["energy_unexplained"] = samples[-1]["energy_unexplained_J"] / samples[-1]["wall_work_J"]
    said = report(folder, bin_folder)
    row["m"] = leading_number(said.get("Singh-Mitchell m"))
    row["rate_10_min_percent_per_min"] = leading_number(said.get("rate at 10 min"))
    return row
