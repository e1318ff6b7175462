# SPDX-License-Identifier: MIT OR Apache-2.0
"""The arrays are what renderers take: size and pose of one known grain, measured in pictures of a packing."""
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
