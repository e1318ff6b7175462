# SPDX-License-Identifier: MIT OR Apache-2.0
"""The arrays are what renderers take: size and pose of one known grain, measured in pictures of a packing."""
import re
from pathlib import Path

import numpy as np
import pytest

import ellgran

WIDTH = 600
RED = (255, 0, 0)


@pytest.fixture(scope="module")
def packing():
    """A loose packing; the grain 0, triaxial and turned, lies above all others."""
    packing = ellgran.packing("hertz 1e6 0.3", [1.6, 1.0, 0.7], 0.3, count=25, seed=7)
    edge = packing.box.edges[0, 0]
    packing.bodies.positions = packing.box.wrapped(packing.bodies.positions)
    packing.bodies.positions[0] = [0.45 * edge, 0.6 * edge, 1.5 * edge]
    packing.bodies.quaternions[0] = ellgran.random_rotations(1, np.random.default_rng(11))[0]
    return packing


def shadow(bodies, k):
    """Centre and second moments of the area of a grain's shadow along z: a quarter of the shadow's shape matrix."""
    rotation = bodies.rotations[k]
    shape = rotation @ np.diag(bodies.semi_axes[k] ** 2) @ rotation.T
    return bodies.positions[k, :2], shape[:2, :2] / 4.0


def measured(picture, pixel, corner):
    """The same of all pixels that are red; rows go downwards."""
    red = (picture[..., 0] > 100) & (picture[..., 1] < 60) & (picture[..., 2] < 60)
    rows, columns = np.nonzero(red)
    assert len(rows) > 1000
    x = corner[0] + pixel * (columns + 0.5)
    y = corner[1] + pixel * (picture.shape[0] - rows - 0.5)
    points = np.stack([x, y])
    return points.mean(axis=1), np.cov(points, bias=True)


def is_right(picture, packing, pixel, corner):
    centre, moments = measured(picture, pixel, corner)
    expected_centre, expected = shadow(packing.bodies, 0)
    assert np.abs(centre - expected_centre).max() < pixel
    size, expected_size = np.linalg.eigh(moments), np.linalg.eigh(expected)
    assert 2.0 * np.sqrt(size[0]) == pytest.approx(2.0 * np.sqrt(expected_size[0]), rel=0.015)
    # The long axis of an ellipse that is no circle.
    assert expected_size[0][1] > 1.5 * expected_size[0][0]
    turn = np.degrees(np.arccos(min(1.0, abs(size[1][:, 1] @ expected_size[1][:, 1]))))
    assert turn < 1.0


def test_matplotlib_draws_the_surfaces(packing):
    pytest.importorskip("matplotlib")
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.collections import PolyCollection
    from matplotlib.figure import Figure

    points, triangles = packing.bodies.surfaces(25, 48)
    of_body = np.repeat(np.arange(len(packing.bodies)), len(triangles) // len(packing.bodies))
    corners = points[triangles]
    # The surface encloses the body, and its corners are counter-clockwise from outside.
    volume = np.einsum("ki,ki->k", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6.0
    assert volume == pytest.approx(packing.bodies.volumes.sum(), rel=0.02) and volume > 0
    order = corners[:, :, 2].mean(axis=1).argsort()
    colours = np.where((of_body == 0)[:, None], np.array(RED) / 255.0, 0.6)
    edge = packing.box.edges[0, 0]
    figure = Figure(figsize=(6, 6), dpi=WIDTH / 6)
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set(xlim=(-0.25 * edge, 1.25 * edge), ylim=(-0.25 * edge, 1.25 * edge))
    axes.axis("off")
    axes.add_collection(
        PolyCollection(
            corners[order][:, :, :2], facecolors=colours[order], edgecolors=colours[order], linewidths=0.2, antialiaseds=False
        )
    )
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    is_right(np.asarray(canvas.buffer_rgba()), packing, 1.5 * edge / WIDTH, (-0.25 * edge, -0.25 * edge))


def seen_by_ovito(pipeline, packing):
    """The picture from above, by OVITO's renderer that needs no graphics card; light from all sides leaves red red."""
    from ovito.vis import TachyonRenderer, Viewport
    from PySide6.QtGui import QImage

    edge = packing.box.edges[0, 0]
    # A camera that looks along -z; the field of view is half the height of the picture.
    view = Viewport(
        type=Viewport.Type.Ortho,
        camera_pos=(0.5 * edge, 0.5 * edge, 10 * edge),
        camera_dir=(0, 0, -1),
        camera_up=(0, 1, 0),
        fov=0.75 * edge,
    )
    light = TachyonRenderer(
        ambient_occlusion_samples=4, ambient_occlusion_brightness=1.0, direct_light=False, antialiasing=False
    )
    pipeline.add_to_scene()
    picture = view.render_image(size=(WIDTH, WIDTH), renderer=light).convertToFormat(QImage.Format.Format_RGBA8888)
    pipeline.remove_from_scene()
    # The picture owns its pixels.
    return np.frombuffer(picture.constBits(), np.uint8).reshape(WIDTH, WIDTH, 4).copy()


def test_ovito_renders_the_arrays(packing):
    pytest.importorskip("ovito")
    from ovito.data import DataCollection
    from ovito.pipeline import Pipeline, StaticSource

    data = DataCollection()
    particles = data.create_particles(count=len(packing.bodies))
    particles.create_property("Position", data=packing.bodies.positions)
    particles.create_property("Orientation", data=packing.bodies.quaternions_xyzw)
    particles.create_property("Aspherical Shape", data=packing.bodies.semi_axes)
    colours = np.full((len(packing.bodies), 3), 0.5)
    colours[0] = np.array(RED) / 255.0
    particles.create_property("Color", data=colours)
    picture = seen_by_ovito(Pipeline(source=StaticSource(data=data)), packing)
    edge = packing.box.edges[0, 0]
    is_right(picture, packing, 1.5 * edge / WIDTH, (-0.25 * edge, -0.25 * edge))


# The names of the columns as LAMMPS writes them, and as `dump_modify colname` of the tutorial has them written.
PLAIN = [f"c_quat[{k}]" for k in range(1, 5)] + [f"c_shape[{k}]" for k in range(1, 4)]
KNOWN = ["quatw", "quati", "quatj", "quatk", "shapex", "shapey", "shapez"]


def test_ovito_reads_the_dump_of_the_tutorial(packing, tmp_path):
    """By itself with the columns' names of the tutorial: shapes are halved, and the order of the quaternion is right."""
    pytest.importorskip("ovito")
    from ovito.io import import_file

    page = (Path(__file__).parents[2] / "docs" / "tutorials" / "spheres_to_ellipsoids.md").read_text()
    renamed = dict(re.findall(r"colname (\S+) (\S+)", page))
    assert renamed == dict(zip(PLAIN, KNOWN))
    bodies = packing.bodies
    rows = np.column_stack([bodies.positions, bodies.quaternions, 2.0 * bodies.semi_axes])
    box = "\n".join(f"0 {edge:.17g}" for edge in np.diag(packing.box.edges))
    with open(tmp_path / "grains.dump", "w") as file:
        file.write(f"ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n{len(rows)}\nITEM: BOX BOUNDS pp pp pp\n{box}\n")
        file.write(f"ITEM: ATOMS id type x y z {' '.join(renamed[name] for name in PLAIN)}\n")
        for k, row in enumerate(rows):
            file.write(f"{k + 1} {1 + (k > 0)} {' '.join(format(x, '.17g') for x in row)}\n")
    pipeline = import_file(str(tmp_path / "grains.dump"))
    particles = pipeline.compute().particles
    assert np.allclose(particles["Aspherical Shape"], bodies.semi_axes, rtol=1e-6)
    signs = np.sign((particles["Orientation"] * bodies.quaternions_xyzw).sum(axis=1))
    assert np.allclose(signs[:, None] * particles["Orientation"], bodies.quaternions_xyzw, atol=1e-6)

    def coloured(frame, data):
        data.particles_.create_property("Color", data=np.where(data.particles["Particle Type"][:, None] == 1, [1, 0, 0], 0.5))

    pipeline.modifiers.append(coloured)
    picture = seen_by_ovito(pipeline, packing)
    edge = packing.box.edges[0, 0]
    is_right(picture, packing, 1.5 * edge / WIDTH, (-0.25 * edge, -0.25 * edge))


def dense():
    """A packing with contacts over its periodic boundaries, and the contacts."""
    packing = ellgran.packing("hertz 1e6 0.3", [1.5, 1.0, 0.8], 0.68, count=80, seed=3)
    packing.bodies.positions = packing.box.wrapped(packing.bodies.positions)
    contacts = packing.contacts("hertz 1e6 0.3")
    assert len(contacts) > 80 and contacts.images.any()
    return packing, contacts


def test_a_network_has_a_line_for_each_contact():
    packing, contacts = dense()
    points, lines = packing.network(contacts.pairs, contacts.images)
    assert np.allclose(points[lines[:, 1]] - points[lines[:, 0]], contacts.branch, atol=1e-12)
    # A dump has identifiers and no images. In a box more than twice as wide as a contact reaches, the nearest is the one.
    packing.bodies.identifiers = np.random.default_rng(5).permutation(1000)[: len(packing.bodies)]
    pairs = packing.indices(packing.bodies.identifiers[contacts.pairs])
    assert (pairs == contacts.pairs).all()
    assert packing.box.edges[0, 0] > 2.0 * np.linalg.norm(contacts.branch, axis=1).max()
    assert np.allclose(packing.network(pairs)[0], points, atol=1e-12)
    with pytest.raises(ValueError, match="identifier 1001"):
        packing.indices([[1001, 1001]])


def test_paraview_gets_the_network(tmp_path):
    """As docs/python.md writes it; ParaView's own library reads it."""
    pyvista = pytest.importorskip("pyvista", exc_type=ImportError)
    packing, contacts = dense()
    points, lines = packing.network(contacts.pairs, contacts.images)
    network = pyvista.PolyData(points, lines=np.insert(lines, 0, 2, axis=1))
    network.cell_data["normal force"] = contacts.normal_force
    network.save(tmp_path / "network.vtp")
    read = pyvista.read(tmp_path / "network.vtp")
    assert read.n_lines == len(contacts)
    assert np.allclose(read.compute_cell_sizes(area=False, volume=False)["Length"], np.linalg.norm(contacts.branch, axis=1))
    assert np.allclose(read["normal force"], contacts.normal_force)


def test_ovito_gets_the_network():
    pytest.importorskip("ovito")
    from ovito.data import DataCollection, SimulationCell

    packing, contacts = dense()
    data = DataCollection()
    cell = SimulationCell(pbc=(True, True, True))
    cell[:, :3] = packing.box.edges.T
    data.objects.append(cell)
    particles = data.create_particles(count=len(packing.bodies))
    particles.create_property("Position", data=packing.bodies.positions)
    bonds = particles.create_bonds(count=len(contacts))
    bonds.create_property("Topology", data=contacts.pairs)
    bonds.create_property("Periodic Image", data=contacts.images)
    bonds.create_property("Normal force", data=contacts.normal_force)
    first, second = (np.asarray(particles.positions)[bonds.topology[:, k]] for k in (0, 1))
    vectors = second + np.asarray(bonds.pbc_vectors) @ np.asarray(data.cell[:, :3]).T - first
    assert np.allclose(vectors, contacts.branch, atol=1e-5)


def test_ovito_reads_the_network_of_the_page(tmp_path):
    """The dump of the plugin's page, loaded with the columns that it names; pairs that do not touch are selected by their force."""
    pytest.importorskip("ovito")
    from ovito.io import import_file
    from ovito.modifiers import LoadTrajectoryModifier

    packing, contacts = dense()
    page = (Path(__file__).parents[2] / "lammps-plugin" / "README.md").read_text()
    dump = re.search(r"^dump network all local 1000 \S+ (.*)$", page, re.M)[1].split()
    columns = [name.strip() for name in re.search(r"^Columns for OVITO: (.*)\.$", page, re.M)[1].replace("`", "").split(",")]
    assert len(columns) == len(dump)
    bodies = packing.bodies
    box = "\n".join(f"0 {edge:.17g}" for edge in np.diag(packing.box.edges))

    def write(name, what, title, rows):
        with open(tmp_path / name, "w") as file:
            file.write(f"ITEM: TIMESTEP\n0\nITEM: NUMBER OF {what}\n{len(rows)}\nITEM: BOX BOUNDS pp pp pp\n{box}\n")
            file.write(f"ITEM: {title}\n" + "\n".join(" ".join(f"{x:.17g}" for x in row) for row in rows) + "\n")

    ones = np.ones(len(bodies))
    write("grains.dump", "ATOMS", "ATOMS id type x y z", np.column_stack([bodies.identifiers + 1, ones, bodies.positions]))
    identifiers = bodies.identifiers[contacts.pairs] + 1
    touching = np.column_stack([np.arange(len(contacts)) + 1, identifiers, contacts.penetration, contacts.normal_force])
    apart = [[len(contacts) + 1, 1, 2, 0.0, 0.0]]
    write("network.dump", "ENTRIES", f"ENTRIES {' '.join(dump)}", np.concatenate([touching, apart]))
    pipeline = import_file(str(tmp_path / "grains.dump"))
    modifier = LoadTrajectoryModifier()
    modifier.source.load(str(tmp_path / "network.dump"), columns=[None if name == "none" else name for name in columns])
    pipeline.modifiers.append(modifier)
    data = pipeline.compute()
    bonds = data.particles.bonds
    force = np.asarray(bonds["Normal force"])
    assert np.allclose(force[force > 0], contacts.normal_force, rtol=1e-5) and len(force) == len(contacts) + 1
    positions = np.asarray(data.particles.positions)
    images = np.asarray(bonds["Periodic Image"])
    vectors = positions[bonds.topology[:, 1]] - positions[bonds.topology[:, 0]] + images @ packing.box.edges
    assert np.allclose(vectors[force > 0], contacts.branch, atol=1e-5)


def test_pandas_takes_the_columns(packing):
    pandas = pytest.importorskip("pandas")
    contacts = packing.contacts("hertz 1e6 0.3")
    table = pandas.DataFrame(contacts.columns())
    assert len(table) == len(contacts.penetration)
    assert (table["penetration"] == contacts.penetration).all()
    assert (table[["force_x", "force_y", "force_z"]].to_numpy() == contacts.force).all()


@pytest.mark.parametrize("how", ["surfaces", "tensor glyphs"])
def test_pyvista_renders_them(packing, how):
    pyvista = pytest.importorskip("pyvista", exc_type=ImportError)
    plotter = pyvista.Plotter(off_screen=True, window_size=(WIDTH, WIDTH))
    others, one = packing.bodies[1:], packing.bodies[:1]
    for bodies, colour in ((others, "grey"), (one, "red")):
        if how == "surfaces":
            mesh = pyvista.PolyData.from_regular_faces(*bodies.surfaces(33, 64))
        else:
            vtk = pytest.importorskip("vtk")
            cloud = pyvista.PolyData(bodies.positions)
            cloud.point_data["shape"] = bodies.shape_tensors.reshape(-1, 9)
            cloud.GetPointData().SetActiveTensors("shape")
            glyphs = vtk.vtkTensorGlyph()
            glyphs.SetInputData(cloud)
            glyphs.SetSourceData(pyvista.Sphere(radius=1.0, theta_resolution=64, phi_resolution=64))
            glyphs.ExtractEigenvaluesOff()
            glyphs.ColorGlyphsOff()
            glyphs.Update()
            mesh = pyvista.wrap(glyphs.GetOutput())
        plotter.add_mesh(mesh, color=colour, lighting=False)
    edge = packing.box.edges[0, 0]
    plotter.enable_parallel_projection()
    plotter.camera_position = [(0.5 * edge, 0.5 * edge, 10 * edge), (0.5 * edge, 0.5 * edge, 0.0), (0, 1, 0)]
    plotter.camera.parallel_scale = 0.75 * edge
    plotter.reset_camera_clipping_range()
    picture = plotter.screenshot(return_img=True)
    plotter.close()
    is_right(np.asarray(picture), packing, 1.5 * edge / WIDTH, (-0.25 * edge, -0.25 * edge))
