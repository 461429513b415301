#!/usr/bin/env python3
"""Reads every picture of a folder as strictly as a viewer may: check_snapshots.py [--vtk] FOLDER

XML, base64 with its length, counts, cells that join points that are there, collections that name each file once with
its time. With --vtk, VTK's own reader must find the same numbers. Ends with a line on what was read, or an error.
"""
import base64
import math
import pathlib
import struct
import sys
import xml.etree.ElementTree as ElementTree

POINT_ARRAYS = {
    "particles": {"id": 1, "parent": 1, "generation": 1, "radius": 1, "diameter_mm": 1, "velocity": 3,
                  "mobilised_stress_Pa": 1, "limit_stress_Pa": 1, "stress_ratio": 1, "crack_ratio": 1},
    "contacts": {},
}
CELL_ARRAYS = {
    "particles": {},
    "contacts": {"normal_force_N": 1, "shear_force_N": 1, "sliding": 1, "overlap_m": 1},
}


def require(condition, what):
    if not condition:
        sys.exit(f"check_snapshots: {what}")


def numbers(element, where):
    """The numbers of an inline binary DataArray."""
    require(element.get("format") == "binary", f"{where}: not binary")
    raw = base64.b64decode(element.text.encode("ascii"), validate=True)
    require(len(raw) >= 8, f"{where}: no header")
    (length,) = struct.unpack_from("<Q", raw)
    require(length == len(raw) - 8 and length % 8 == 0, f"{where}: header {length}, {len(raw) - 8} bytes")
    kind = {"Float64": "d", "Int64": "q"}[element.get("type")]
    return struct.unpack(f"<{length // 8}{kind}", raw[8:])


def arrays(section, components, count, where):
    found = {}
    for element in section:
        name = element.get("Name")
        values = numbers(element, f"{where}, {name}")
        require(len(values) == components[name] * count, f"{where}, {name}: {len(values)} numbers, {count} tuples")
        require(int(element.get("NumberOfComponents")) == components[name], f"{where}, {name}: components")
        require(all(math.isfinite(value) for value in values), f"{where}, {name}: not finite")
        found[name] = values
    require(found.keys() == components.keys(), f"{where}: arrays {sorted(found)}")
    return found


def read(path):
    """Time and arrays of one file, by section."""
    kind, where = path.name.split("_")[0], path.name
    root = ElementTree.parse(path).getroot()
    attributes = {"type": "PolyData", "byte_order": "LittleEndian", "header_type": "UInt64", "version": "1.0"}
    require(root.tag == "VTKFile" and root.attrib == attributes, f"{where}: head {root.attrib}")
    (poly_data,) = root
    field, piece = poly_data
    time = {element.get("Name"): float(element.text) for element in field}["TimeValue"]
    points, verts, lines = (int(piece.get(f"NumberOf{what}")) for what in ("Points", "Verts", "Lines"))
    sections = {section.tag: section for section in piece}
    read_arrays = arrays(sections["PointData"], POINT_ARRAYS[kind], points, where)
    read_arrays |= arrays(sections["CellData"], CELL_ARRAYS[kind], verts + lines, where)
    read_arrays |= arrays(sections["Points"], {"Points": 3}, points, where)
    require(points > 0, f"{where}: no point")
    require((verts, lines > 0) == ((points, False) if kind == "particles" else (0, True)), f"{where}: cells")
    for tag, nodes, count in (("Verts", 1, verts), ("Lines", 2, lines)):
        connectivity, offsets = (numbers(element, f"{where}, {tag}") for element in sections[tag])
        require(list(offsets) == [nodes * (k + 1) for k in range(count)], f"{where}, {tag}: offsets")
        require(len(connectivity) == nodes * count, f"{where}, {tag}: connectivity")
        require(all(0 <= point < points for point in connectivity), f"{where}, {tag}: a point that is not there")
    if kind == "particles":
        identifiers = read_arrays["id"]
        require(all(a < b for a, b in zip(identifiers, identifiers[1:])), f"{where}: ids do not ascend")
        require(max(read_arrays["stress_ratio"]) > 0.0, f"{where}: no stress")
    else:
        require(set(read_arrays["sliding"]) <= {0, 1}, f"{where}: sliding")
        require(min(read_arrays["overlap_m"]) > 0.0, f"{where}: a contact that does not touch")
        require(min(read_arrays["normal_force_N"]) > 0.0, f"{where}: a contact without force")
    return time, read_arrays


def compare_with_vtk(path, ours):
    import vtk  # pylint: disable=import-outside-toplevel

    complaints = []
    reader = vtk.vtkXMLPolyDataReader()
    for event in ("ErrorEvent", "WarningEvent"):
        reader.AddObserver(event, lambda *_: complaints.append(path.name))
    reader.SetFileName(str(path))
    reader.Update()
    require(not complaints and reader.GetErrorCode() == 0, f"{path.name}: VTK complains")
    data = reader.GetOutput()
    found = {"Points": data.GetPoints().GetData()}
    for section in (data.GetPointData(), data.GetCellData()):
        found |= {section.GetArrayName(k): section.GetArray(k) for k in range(section.GetNumberOfArrays())}
    require(found.keys() == ours.keys(), f"{path.name}: VTK finds {sorted(found)}")
    for name, theirs in found.items():
        values = tuple(x for k in range(theirs.GetNumberOfTuples()) for x in theirs.GetTuple(k))
        require(values == ours[name], f"{path.name}, {name}: VTK reads other numbers")
    require(data.GetNumberOfCells() == data.GetNumberOfVerts() + data.GetNumberOfLines(), f"{path.name}: cells")
    time = data.GetFieldData().GetArray("TimeValue")
    require(time is not None and time.GetNumberOfTuples() == 1, f"{path.name}: VTK finds no time")


def main():
    with_vtk = sys.argv[1] == "--vtk"
    folder = pathlib.Path(sys.argv[-1])
    read_files = 0
    for kind in ("particles", "contacts"):
        root = ElementTree.parse(folder / f"{kind}.pvd").getroot()
        require(root.get("type") == "Collection", f"{kind}.pvd: head")
        entries = [(entry.get("file"), float(entry.get("timestep"))) for entry in root[0]]
        present = sorted(path.name for path in folder.glob(f"{kind}_*.vtp"))
        require([name for name, _ in entries] == present, f"{kind}.pvd: does not list what is there, in order")
        require(all(a[1] < b[1] for a, b in zip(entries, entries[1:])), f"{kind}.pvd: times do not rise")
        for name, time in entries:
            own_time, values = read(folder / name)
            require(own_time == time, f"{name}: time {own_time}, in the collection {time}")
            if with_vtk:
                compare_with_vtk(folder / name, values)
            read_files += 1
    require(read_files > 0, "no picture")
    print(f"{read_files} pictures are whole{', for VTK too' if with_vtk else ''}")


main()
