"""Shapes of files: their poses are MuJoCo's and Drake's own, the hulls of their meshes hold what
the meshes hold, and a mesh that is none is told of in words."""

import re
import struct
from html import unescape

import numpy as np
import pytest

import freebody as fb
from support.command import run
from support.extras import extra
from support.helpers import homogeneous_of
from support.page_data import page_scene

pytestmark = pytest.mark.usefixtures("numpy_kernels")

TURNS = ('quat="0.3 -0.5 0.7 0.1"', 'euler="20 30 40"', 'axisangle="1 -2 0.5 70"', 'zaxis="1 2 3"')
SIZES = {
    "box": "0.05 0.1 0.2",
    "cylinder": "0.05 0.2",
    "sphere": "0.07",
    "capsule": "0.04 0.3",
    "ellipsoid": "0.05 0.1 0.2",
}


def mjcf_arm(seed: int, compiler: str) -> str:
    """An arm with a geom of each kind, turned in each way, on each of two links; some by a class,
    by their ends, hidden, or of a mesh."""
    rng = np.random.default_rng(seed)
    geoms = [
        f'<geom type="{kind}" size="{size}" pos="{x:.3f} {y:.3f} {z:.3f}" {turn}/>'
        for (kind, size), turn, (x, y, z) in zip(
            SIZES.items(), (*TURNS, "")[seed % 3 :] + TURNS, rng.normal(size=(5, 3)), strict=False
        )
    ]
    ends = '<geom class="pipe" fromto="0 0.1 0 0.4 -0.2 0.5"/>'
    hidden = '<geom type="box" size="0.3 0.3 0.3" group="3"/>'
    mesh = f'<geom type="mesh" mesh="wedge" pos="0.1 0.2 0.3" {TURNS[0]}/>'
    return f"""<mujoco model="arm"><compiler {compiler}/>
    <default><default class="pipe"><geom type="cylinder" size="0.03"/></default></default>
    <asset><mesh name="wedge" vertex="0 0 0 1 0 0 0 2 0 0 0 3 0.1 0.1 0.1" scale="0.1 0.1 0.2"/>
    </asset><worldbody><geom type="plane" size="1 1 0.1"/><body name="a" pos="1 2 3"
    euler="0.1 0.2 0.3"><joint axis="1 2 3" pos="0.2 0 0.1"/>{"".join(geoms)}{ends}<body name="b"
    pos="0.5 0 0"><joint axis="0 1 0"/><joint type="slide" axis="1 0 1"/>{hidden}{mesh}{geoms[-1]}
    </body></body></worldbody></mujoco>"""


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    ("seed", "compiler"),
    [(0, ""), (1, 'angle="radian" eulerseq="ZYX"'), (2, 'eulerseq="xzy"')],
)
def test_shapes_of_mjcf_are_where_mujoco_has_them(seed, compiler):
    mujoco = extra("mujoco")
    text = mjcf_arm(seed, compiler)
    theirs = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(theirs)
    model = fb.load(text=text, format="mjcf")
    q = np.random.default_rng(seed).normal(size=model.nq)
    data.qpos[:] = q
    mujoco.mj_kinematics(theirs, data)
    assert len(model.shapes) == theirs.ngeom - 1  # without the plane
    for k, (frame, shape) in enumerate(model.shapes, 1):
        assert shape.role == ("collision" if theirs.geom_group[k] > 2 else "visual")
        T = fb.forward_kinematics(model, q, frame) @ homogeneous_of(shape.placement)
        np.testing.assert_allclose(T[:3, 3], data.geom_xpos[k], atol=1e-12)
        np.testing.assert_allclose(T[:3, :3].ravel(), data.geom_xmat[k], atol=1e-12)
        if shape.kind == "hull":
            start = theirs.mesh_vertadr[0]
            expected = theirs.mesh_vert[start : start + 4]  # the fifth lies within
            found = np.array(shape.points)
            assert len(found) == 4
            apart = np.linalg.norm(found[:, None] - expected, axis=-1)
            assert apart.min(axis=0).max() == 0.0
        else:
            own, half = shape.size, theirs.geom_size[k]
            factors = {"box": (2, 2, 2), "cylinder": (1, 2), "capsule": (1, 2)}
            np.testing.assert_array_equal(own, half[: len(own)] * factors.get(shape.kind, 1))


SDF = """<sdf version="1.9"><model name="arm"><pose>0.1 0.2 0.3 0.4 0.5 0.6</pose>
<link name="a"><pose>0 0 1 0.1 0.2 0.3</pose>{inertial}
<visual name="box"><pose>0.1 0 0.2 0.3 0.4 0.5</pose><geometry><box><size>0.1 0.2 0.3</size></box>
</geometry></visual>
<visual name="ball"><geometry><sphere><radius>0.1</radius></sphere></geometry></visual>
<visual name="rod"><pose relative_to="grip">0.1 0.2 0.3 0.7 0 0</pose><geometry><capsule>
<radius>0.05</radius><length>0.4</length></capsule></geometry></visual>
<collision name="pipe"><pose relative_to="__model__">1 0 0 0 0.3 0</pose><geometry><cylinder>
<radius>0.05</radius><length>0.4</length></cylinder></geometry></collision>
<collision name="egg"><pose degrees="true">1 0 0 10 20 30</pose><geometry><ellipsoid><radii>0.1 0.2
0.3</radii></ellipsoid></geometry></collision></link>
<frame name="grip" attached_to="a"><pose>0.3 0.2 0.1 0.2 0 1</pose></frame>
<joint name="j" type="revolute"><parent>world</parent><child>a</child><axis><xyz>0 1 0</xyz></axis>
</joint><model name="tool"><pose>0.2 0 0 0 1.1 0</pose><link name="b">{inertial}<visual name="v">
<pose relative_to="tip">0.1 0 0 0 0 0.2</pose><geometry><box><size>1 2 3</size></box></geometry>
</visual></link><frame name="tip"><pose>0 0.1 0 0.3 0 0</pose></frame></model>
<joint name="k" type="revolute"><parent>a</parent><child>tool::b</child><axis><xyz>1 0 0</xyz>
</axis></joint></model></sdf>""".format(
    inertial="<inertial><mass>1</mass><inertia><ixx>0.1</ixx><iyy>0.1</iyy><izz>0.1</izz></inertia>"
    "</inertial>"
)


def test_shapes_of_sdf_are_where_drake_has_them():
    extra("pydrake", "Drake")
    from pydrake.geometry import Role, SceneGraph
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant

    plant, scenes = MultibodyPlant(0.0), SceneGraph()
    plant.RegisterAsSourceForSceneGraph(scenes)
    Parser(plant).AddModelsFromString(SDF, "sdf")
    plant.Finalize()
    inspector, model = scenes.model_inspector(), fb.load(text=SDF, format="sdf")
    kinds, seen = {"visual": Role.kIllustration, "collision": Role.kProximity}, 0
    for name, scoped in (("a", "arm"), ("tool::b", "arm::tool")):
        body = plant.GetBodyByName(name[-1], plant.GetModelInstanceByName(scoped))
        frame = plant.GetBodyFrameIdOrThrow(body.index())
        for role, kind in kinds.items():
            own = [x for at, x in model.shapes if at == name and x.role == role]
            found = [homogeneous_of(x.placement) for x in own]
            poses = [
                inspector.GetPoseInFrame(x).GetAsMatrix4()
                for x in inspector.GetGeometries(frame, kind)
            ]
            assert len(poses) == len(found)
            seen += len(found)
            for T in found:
                assert min(np.abs(T - pose).max() for pose in poses) < 1e-12
    assert seen == len(model.shapes) == 6


def test_what_is_no_shape_of_an_sdf_is_told():
    for wrong, told in (
        ("<size>0.1 0.2</size>", "<size> has 2 numbers, expected 3; this shape is left out."),
        ("<size>0.1 0 0.3</size>", "a size of <box> is not above 0; this shape is left out."),
        ("", "<box> has no <size>; this shape is left out."),
    ):
        model = fb.load(text=SDF.replace("<size>0.1 0.2 0.3</size>", wrong), format="sdf")
        assert len(model.shapes) == 5
        assert [x.line for x in model.notices if x.text.endswith(told)] == [3]


def urdf(geometry: str, mass: float = 2.0, more: str = "") -> str:
    """An arm of one link with a shape."""
    return f"""<robot name="arm"><link name="base"/><link name="link"><inertial><mass
value="{mass}"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>
<visual><origin xyz="0.1 0.2 0.3" rpy="0.3 0.2 0.1"/><geometry>{geometry}</geometry></visual>{more}
</link><joint name="j" type="revolute"><parent link="base"/><child link="link"/><origin
xyz="0 0 0.5"/><axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="9" velocity="9"/></joint>
</robot>"""


@pytest.mark.parametrize(
    ("ours", "theirs"),
    [
        ('<capsule radius="0.1" length="0.4"/>', 'type="capsule" size="0.1 0.2"'),
        ('<drake:ellipsoid a="0.1" b="0.2" c="0.3"/>', 'type="ellipsoid" size="0.1 0.2 0.3"'),
    ],
)
def test_solids_are_filled_as_mujoco_fills_them(ours, theirs):
    mujoco = extra("mujoco")
    text = f'<mujoco><worldbody><body><joint/><geom {theirs} mass="2"/></body></worldbody></mujoco>'
    expected = mujoco.MjModel.from_xml_string(text).body_inertia[1]
    model = fb.load(text=urdf(ours), format="urdf", estimate_inertia=2.0)
    _, _, tensor = model.bodies[0].inertias[0].inertia.numbers()
    np.testing.assert_allclose(np.sort(np.linalg.eigvalsh(tensor)), np.sort(expected), rtol=1e-12)


# ---------------------------------------------------------------- meshes
CORNER = np.array([[0, 0, 0], [0.3, 0, 0], [0, 0.2, 0], [0, 0, 0.1]])
TETRAHEDRON = CORNER[[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]]


def test_a_mirrored_mesh_is_filled_as_its_mirror_image(tmp_path):
    """The centre of a tetrahedron is the mean of its corners."""
    extra("trimesh", name="mesh")
    (tmp_path / "corner.stl").write_bytes(stl(TETRAHEDRON))
    file = tmp_path / "arm.urdf"
    file.write_text(urdf('<mesh filename="corner.stl" scale="1 -1 2"/>'))
    model = fb.load(file, estimate_inertia=2.0)
    T = homogeneous_of(model.shapes[0][1].placement)
    _, com, _ = model.bodies[0].inertias[0].inertia.numbers()
    expected = T[:3, :3] @ (CORNER.mean(axis=0) * [1, -1, 2]) + T[:3, 3]
    np.testing.assert_allclose(com, expected, atol=1e-8)


def stl(triangles: np.ndarray, count: int | None = None) -> bytes:
    """A binary STL file of triangles (n, 3, 3), which tells of `count` of them."""
    body = b"".join(
        struct.pack("<12f2x", 0, 0, 0, *corners.ravel()) for corners in triangles.astype("<f4")
    )
    return b"head".ljust(80) + struct.pack("<I", len(triangles) if count is None else count) + body


def text_of(triangles: np.ndarray, word: str, between: str = "") -> bytes:
    """Lines of corners, as STL in text and OBJ have them."""
    lines = (f" {word} {x} {y} {z}" for x, y, z in triangles.reshape(-1, 3).astype("<f4"))
    return f"{between}\n{chr(10).join(lines)}\n".encode()


CLOUD = np.random.default_rng(4).normal(size=(200, 3, 3)) * [0.2, 0.1, 0.05]
FORMS = {
    "binary.stl": stl(CLOUD),
    "ascii.STL": text_of(CLOUD, "vertex", "solid cloud"),
    "cloud.obj": text_of(CLOUD, "v", "o cloud\nvn 1 0 0"),
}


def studio(text: str, folder) -> tuple[dict, str]:
    """The scene of the studio's page of a URDF, and the words of the page."""
    (folder / "arm.urdf").write_text(text)
    out = folder / "index.html"
    assert run(["studio", str(folder / "arm.urdf"), "--no-open", "--out", str(out)]) == 0
    html = out.read_text(encoding="utf-8")
    return page_scene(html), unescape(re.sub(r"<[^>]*>", "", html))


@pytest.mark.parametrize("name", FORMS)
def test_the_hull_of_a_mesh(name, tmp_path):
    """Its corners are among those of the mesh, mirrored and placed; no others lie farther out along
    the edges, faces and corners of a cube; its faces are closed and turned outwards."""
    from scipy.spatial import ConvexHull

    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / name).write_bytes(FORMS[name])
    mesh = f'<mesh filename="package://arm/meshes/{name}" scale="1 -1 2"/>'
    scene, words = studio(urdf(mesh), tmp_path)
    assert "Bodies are drawn by hulls of the file's meshes (1 hull, 1 kB)." in words
    (drawn,) = [x for x in scene["solids"] if isinstance(x[4], list)]
    role, first, second, _, corners, faces, bodies = drawn
    assert (role, first[0], second[0], bodies) == ("link", 1, 1, [0])
    corners, faces = np.array(corners).reshape(-1, 3), np.array(faces).reshape(-1, 3)
    T = homogeneous_of(fb.load(tmp_path / "arm.urdf").shapes[0][1].placement)
    cloud = CLOUD.reshape(-1, 3).astype("<f4") * [1, -1, 2] @ T[:3, :3].T + T[:3, 3]
    assert len(faces) <= 48
    apart = np.linalg.norm(corners[:, None] - cloud, axis=-1)
    assert apart.min(axis=1).max() < 2e-6  # a drawing is rounded to a micrometre
    ways = np.array(np.meshgrid(*[(-1, 0, 1)] * 3)).reshape(3, -1)
    assert np.abs((corners @ ways).max(axis=0) - (cloud @ ways).max(axis=0)).max() < 4e-6
    a, b, c = (corners[faces[:, k]] for k in range(3))
    volume = (np.cross(a, b) * c).sum() / 6.0
    assert np.isclose(volume, ConvexHull(corners).volume, rtol=1e-9)
    assert 0.5 < volume / ConvexHull(cloud).volume < 1.0


NAN = CLOUD[:2].copy()
NAN[1, 2, 0] = np.nan
SIGNAL = bytearray(stl(CLOUD[:2]))
SIGNAL[96:100] = struct.pack("<I", 0x7FA00000)  # a NaN that NumPy warns of
WRONG = {
    "count.stl": (stl(CLOUD, 201), "it tells of 201 triangles, and its length is that of 200"),
    "empty.stl": (stl(CLOUD[:0]), "there are no triangles in it"),
    "signal.stl": (bytes(SIGNAL), "a corner is not of numbers below 1e+06"),
    "nan.stl": (stl(NAN), "a corner is not of numbers below 1e+06"),
    "words.stl": (
        b"solid\nvertex 1 two 3\n",
        "a line that begins with vertex has no three numbers",
    ),
    "short.obj": (b"v 1 2 3\nv 1 2\n", "a line that begins with v has no three numbers"),
    "none.obj": (b"# nothing\n", "there are no triangles in it"),
    "mesh.step": (b"ISO-10303-21;", "a mesh is of the formats .stl, .obj, .ply, .dae"),
    "long.stl": (None, "the file has more than 64 MB, too much for a mesh that is drawn"),
    "unit.obj": (text_of(1e3 * CLOUD, "v"), "m, and the robot 0.5 m: give its scale"),
    "lost.stl": (b"", "not found beside the robot's file, above it or in the folders of packages"),
}


def test_meshes_that_are_none_are_told(tmp_path):
    """In one link, which is then drawn as a bar, or by what it collides with."""
    for name, (data, _) in WRONG.items():
        with open(tmp_path / name, "wb") as file:
            file.write(data or b"")
            if data is None:
                file.truncate(65 * 2**20)
    (tmp_path / "lost.stl").unlink()
    meshes = "".join(f'<mesh filename="{name}"/>' for name in WRONG)
    scene, words = studio(urdf(meshes), tmp_path)
    assert not [x for x in scene["solids"] if isinstance(x[4], list)]
    assert "Bodies are drawn as bars between their joints." in words
    for name, (_, reason) in WRONG.items():
        assert re.search(rf"'{name}'[^(]*\([^)]*{re.escape(reason)}\)", words)
    box = '<collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision>'
    _, words = studio(urdf(meshes, more=box), tmp_path)
    assert "Bodies are drawn by shapes of the file. Shown are the shapes for collisions." in words


def test_a_flat_mesh_has_a_hull(tmp_path):
    flat = CLOUD * [1, 0, 1]
    (tmp_path / "flat.stl").write_bytes(stl(flat))
    scene, _ = studio(urdf('<mesh filename="flat.stl"/>'), tmp_path)
    (drawn,) = [x for x in scene["solids"] if isinstance(x[4], list)]
    corners = np.array(drawn[4]).reshape(-1, 3)
    assert 0.0 < np.linalg.svd(corners - corners.mean(axis=0))[1][2] < 0.01


def test_a_mesh_that_is_a_point_but_for_rounding_has_no_hull(tmp_path):
    (tmp_path / "dot.stl").write_bytes(stl(CLOUD))
    scene, words = studio(urdf('<mesh filename="dot.stl" scale="1e-15 1e-15 1e-15"/>'), tmp_path)
    assert not [x for x in scene["solids"] if isinstance(x[4], list)]
    assert "Bodies are drawn as bars between their joints." in words


def test_a_mesh_outside_the_package_is_opened_where_the_user_names_its_folder(tmp_path):
    robot, other = tmp_path / "arm", tmp_path / "other"
    robot.mkdir()
    other.mkdir()
    (other / "cloud.stl").write_bytes(FORMS["binary.stl"])
    (robot / "arm.urdf").write_text(urdf('<mesh filename="../other/cloud.stl"/>'))
    told = []
    for more in ([], ["--package-path", str(other)]):
        out = tmp_path / "index.html"
        command = ["studio", str(robot / "arm.urdf"), *more, "--no-open", "--out", str(out)]
        assert run(command) == 0
        told.append(out.read_text(encoding="utf-8"))
    assert "&#39;cloud.stl&#39; (outside the package of the robot&#39;s file" in told[0]
    assert "hulls of the file&#39;s meshes (1 hull" in told[1]
