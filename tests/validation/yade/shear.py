# yade -n -x -j1 shear.py START STRESS FRICTION SPEED STEP EVERY COUNT TABLE
#
# Smooth quartz spheres that may turn, between rigid frictionless walls: TriaxialStressController holds the sides at STRESS [Pa]
# while top and bottom close at about SPEED [m/s] (YADE takes a rate). A row of TABLE every EVERY steps of STEP [s].
import sys
from math import atan, sqrt

start, stress, friction, speed, step, every, count, table = sys.argv[1:9]
stress, friction, speed, step, every, count = float(stress), float(friction), float(speed), float(step), int(every), int(count)
YOUNG, POISSON, DENSITY = 76.16e9, 0.19, 2650.0

with open(start) as file:
    box = [float(word) for word in file.readline().split("box")[1].split()[:6]]
    grains = [tuple(float(word) for word in line.split()) for line in file]

# creepd's walls have E' and r' = R; YADE gives a grain at a box r' = R / 2. 1 / E' = (1 - nu^2) / E + (1 - nu_w^2) / E_w must
# make E' of the wall sqrt(2) times that of two grains.
reduced = YOUNG / (2.0 * (1.0 - POISSON**2))
young_of_wall = (1.0 - POISSON**2) / (1.0 / (sqrt(2.0) * reduced) - (1.0 - POISSON**2) / YOUNG)
O.materials.append(FrictMat(young=YOUNG, poisson=POISSON, density=DENSITY, frictionAngle=atan(friction), label="grain"))
O.materials.append(FrictMat(young=young_of_wall, poisson=POISSON, density=0, frictionAngle=0, label="wall"))
walls = O.bodies.append(aabbWalls([Vector3(box[:3]), Vector3(box[3:])], thickness=0, oversizeFactor=1.5, material="wall"))
O.bodies.append([sphere((x, y, z), r, material="grain") for x, y, z, r in grains])

lengths = [box[3 + axis] - box[axis] for axis in range(3)]
triax = TriaxialStressController(thickness=0, internalCompaction=False, stressMask=3, goal1=-stress, goal2=-stress,
                                 goal3=-speed / lengths[2], max_vel=1.0, stressDamping=0.25)
rows = []


def size(axis):
    return O.bodies[walls[2 * axis + 1]].state.pos[axis] - O.bodies[walls[2 * axis]].state.pos[axis]


def sample():
    now = [size(axis) for axis in range(3)]
    area = [now[1] * now[2], now[0] * now[2], now[0] * now[1]]
    pressed = [0.5 * (abs(O.forces.f(walls[2 * axis])[axis]) + abs(O.forces.f(walls[2 * axis + 1])[axis])) / area[axis]
               for axis in range(3)]
    volume = now[0] * now[1] * now[2] / (lengths[0] * lengths[1] * lengths[2])
    rows.append((1.0 - now[2] / lengths[2], pressed[2], 0.5 * (pressed[0] + pressed[1]), 1.0 - volume))


O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Box_Aabb()], verletDist=5e-6),
    InteractionLoop([Ig2_Sphere_Sphere_ScGeom(), Ig2_Box_Sphere_ScGeom()], [Ip2_FrictMat_FrictMat_MindlinPhys()],
                    [Law2_ScGeom_MindlinPhys_Mindlin()]),
    PyRunner(command="sample()", iterPeriod=every, initRun=True),
    triax,
    NewtonIntegrator(damping=0.7),
]
O.dt = step
O.run(every * count + 1, True)
with open(table, "w") as out:
    out.write("axial_strain,axial_stress_Pa,radial_stress_Pa,volumetric_strain\n")
    out.writelines(",".join(f"{value:.9e}" for value in row) + "\n" for row in rows)
