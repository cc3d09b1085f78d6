"""Kernels as functions of PyTorch tensors: PyTorch's own checks of gradients, its transforms and
its graphs."""

from __future__ import annotations

import copy
import gc
import pickle
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import freebody as fb
from freebody import FreebodyError, MissingValueError, ShapeError
from freebody.targets import TARGETS, Kernel, KernelError
from freebody.targets.call_errors import BatchError
from support.hostile import JOINTS, LINKS, hostile

torch = pytest.importorskip("torch", reason="PyTorch is not installed")

pytestmark = pytest.mark.filterwarnings("default:`torch.jit:DeprecationWarning")  # PyTorch's own


def random(*shape, grad=True, seed=0, dtype=None):
    values = torch.from_numpy(np.random.default_rng(seed).normal(size=shape)).to(
        dtype or torch.float64
    )
    return values.requires_grad_(grad)


def near(model, count, seed=1):
    """States of a mechanism near its home, open or closed, of positions off the unit length of
    quaternions."""
    rng = np.random.default_rng(seed)
    q = fb.neutral(model) + 0.1 * rng.normal(size=(count, model.nq))
    if model.loops:
        q = np.stack([fb.assemble(model, x) for x in q])
    return torch.from_numpy(q)


def free_base():
    return fb.load("quadrotor")


# ---------------------------------------------------------------- numbers
@pytest.mark.parametrize("dtype", ["float64", "float32"])
def test_results_are_the_kernels_to_the_last_bit(dtype):
    model = fb.load("ur5e")
    f, k = fb.to_torch(model, "inverse_dynamics"), fb.kernel(model, "inverse_dynamics", dtype=dtype)
    q, qd, qdd = (
        random(3, 5, 6, grad=False, seed=s, dtype=getattr(torch, dtype)) for s in range(3)
    )
    arrays = [x.numpy() for x in (q, qd, qdd)]
    for made in (f(q, qd, qdd), f(q.requires_grad_(), qd, qdd).detach()):
        assert made.dtype == getattr(torch, dtype)
        np.testing.assert_array_equal(made.numpy(), k(*arrays))
    q.requires_grad_(False)
    assert f(q[0, 0], qd[:, :1], qdd).shape == (3, 5, 6)
    strided = f(q.mT.contiguous().mT, qd[:, 1:2], qdd).numpy()
    np.testing.assert_array_equal(strided, k(arrays[0], arrays[1][:, 1:2], arrays[2]))
    assert f(q[:0], qd[:0], qdd[:0]).shape == (0, 5, 6)


def test_several_outputs_numbers_and_mixed_types():
    model = fb.load("2R")
    energies = fb.to_torch(model, ["kinetic_energy", "potential_energy"])
    T, V = energies(random(4, 2), random(2))
    assert T.shape == V.shape == (4,)
    assert fb.to_torch(model, "potential_energy")(random(2, grad=False)).shape == ()
    step = fb.to_torch(model, "rk4_step")
    q, qd = random(2, grad=False), random(2, grad=False, seed=1)
    q1, qd1 = step(q, qd, torch.zeros(2, dtype=torch.float64), 0.01)
    expected = fb.kernel(model, "rk4_step")(q.numpy(), qd.numpy(), np.zeros(2), 0.01)
    np.testing.assert_array_equal(torch.stack([q1, qd1]).numpy(), np.stack(expected))
    mixed = step(q.float(), qd, torch.zeros(2), 0.01)[0]
    assert mixed.dtype == torch.float64
    single = fb.to_torch(model, "rk4_step", dtype="float32")(q, qd, torch.zeros(2), 0.01)[0]
    assert single.dtype == torch.float32
    assert fb.to_torch(fb.kernel(model, "mass_matrix", dtype="float32"))(q).dtype == torch.float32


def test_tensors_are_read_where_they_lie():
    """A kernel sees the tensor's own memory, and a result is no copy."""
    f = fb.to_torch(fb.compile(lambda x: [x[0] + 1.0, x[1]], {"x": 2}, {"y": 2}))
    seen = []
    own = f._of[torch.float64]
    kernel = own.kernel
    object.__setattr__(own, "kernel", lambda *arrays: (seen.extend(arrays), kernel(*arrays))[1])
    x = random(10, 4, grad=False)[:, ::2]
    y = f(x)
    assert seen[0].__array_interface__["data"][0] == x.data_ptr()
    assert seen[0].strides == (32, 16)
    np.testing.assert_array_equal(y.numpy(), x.numpy() + [1.0, 0.0])


# ---------------------------------------------------------------- derivatives
def quantities():
    arm, loop = fb.load("ur5e"), fb.load("five_bar")
    return {
        "inverse dynamics": (arm, "inverse_dynamics", {}),
        "forward dynamics, with a wrench": (arm, "forward_dynamics", {"wrench_frames": [arm.tip]}),
        "a free base, by quaternions": (free_base(), "forward_dynamics", {}),
        "a closed chain": (loop, "forward_dynamics", {}),
        "several outputs": (fb.load("2R"), ["mass_matrix", "kinetic_energy"], {}),
        "numbers of the robot": (
            fb.load("2R"), "inverse_dynamics", {"inputs": ["link2.mass", "link2.com.x", "gravity"]}
        ),
        "a step": (fb.load("2R"), "rk4_step", {}),
    }  # fmt: skip


@pytest.mark.sample(1)
@pytest.mark.parametrize("case", [
    "inverse dynamics", "forward dynamics, with a wrench", "a free base, by quaternions",
    "a closed chain",
    "several outputs", "numbers of the robot", "a step",
])  # fmt: skip
def test_gradcheck(case):
    """Both modes, batches that broadcast, and inputs without gradient."""
    model, names, options = quantities()[case]
    f = fb.to_torch(model, names, **options)
    given = [
        0.3 * random(*((2, 1) if k % 2 else (3,)), *x.shape, seed=k, grad=False)
        for k, x in enumerate(f.program.inputs)
    ]
    given[0] = near(model, 3)
    given = [x.requires_grad_() for x in given]
    assert torch.autograd.gradcheck(f, given, check_forward_ad=True, eps=1e-6, atol=1e-4)


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    "case",
    ["inverse dynamics", "a free base, by quaternions", "a closed chain", "numbers of the robot"],
)
def test_gradgradcheck(case):
    model, names, options = quantities()[case]
    f = fb.to_torch(model, names, **options)
    given = [0.3 * random(*x.shape, seed=k, grad=False) for k, x in enumerate(f.program.inputs)]
    given[0] = near(model, 1)[0]
    given = [x.requires_grad_() for x in given]
    assert torch.autograd.gradgradcheck(f, given, check_fwd_over_rev=True, atol=1e-4)


def test_transforms_agree_with_each_other_and_with_the_kernels_of_derivatives():
    from torch.func import hessian, jacfwd, jacrev, vmap

    model = fb.load("ur5e")
    f = fb.to_torch(model, "inverse_dynamics")
    q, qd, qdd = (random(3, 6, grad=False, seed=s) for s in range(3))
    expected = fb.inverse_dynamics_derivatives(model, q.numpy(), qd.numpy(), qdd.numpy())
    for transform in (jacrev, jacfwd):
        made = vmap(transform(f, argnums=(0, 1, 2)))(q, qd, qdd)
        for found, table in zip(made, expected, strict=True):
            np.testing.assert_allclose(found.numpy(), table, atol=1e-12)
    model = fb.load("3R")
    f, q, qd, qdd = fb.to_torch(model, "inverse_dynamics"), q[:, :3], qd[:, :3], qdd[:, :3]
    second = vmap(hessian(f))(q, qd, qdd)
    table = fb.inverse_dynamics_second_derivatives(model, q.numpy(), qd.numpy(), qdd.numpy())[0]
    np.testing.assert_allclose(second.numpy(), table, atol=1e-11)


def test_vmap_over_any_axis_nested_and_beside_batches():
    from torch.func import vmap

    f = fb.to_torch(fb.load("2R"), "inverse_dynamics")
    q, qd, qdd = (
        random(3, 4, 2, grad=False),
        random(4, 2, grad=False, seed=1),
        random(2, grad=False, seed=2),
    )
    plain = f(q, qd, qdd)
    for made in (
        vmap(f, (1, 0, None), 1)(q, qd, qdd),
        vmap(f, (0, None, None))(q, qd, qdd),
        vmap(vmap(f, (0, 0, None)), (0, None, None))(q, qd, qdd),
        vmap(f, (2, None, None))(q.movedim(0, 2), qd, qdd),
    ):
        np.testing.assert_array_equal(made.numpy(), plain.numpy())
    step = fb.to_torch(fb.load("2R"), "rk4_step")
    two = vmap(step, (0, None, None, 0))(
        q, qd, qdd, torch.tensor([0.1, 0.2, 0.3], dtype=torch.float64)
    )
    one = step(q, qd, qdd, torch.tensor([[0.1], [0.2], [0.3]], dtype=torch.float64))
    np.testing.assert_array_equal(torch.stack(two).numpy(), torch.stack(one).numpy())


def test_only_what_is_asked_for_is_differentiated():
    f = fb.to_torch(fb.load("2R"), ["inverse_dynamics", "kinetic_energy"])
    own = f._of[torch.float64]
    f(random(2, grad=False), random(2, grad=False), random(2, grad=False))
    assert not own._derivatives
    q = random(2)
    tau, _ = f(q, random(2, grad=False), random(2, grad=False))
    (slope,) = torch.autograd.grad(tau[0], q)
    assert list(own._derivatives) == [((0,), (0,))]
    expected = fb.inverse_dynamics_derivatives(
        fb.load("2R"), q.detach().numpy(), *[random(2, grad=False).numpy()] * 2
    )
    np.testing.assert_allclose(slope.numpy(), expected[0][0], rtol=1e-12)
    with torch.no_grad():
        assert not f(q, q, q)[0].requires_grad


def test_forward_mode_sees_what_has_no_gradient():
    """A direction alone does not make a tensor require a gradient; its memory holds no
    direction."""
    import torch.autograd.forward_ad as forward

    f = fb.to_torch(fb.load("2R"), "potential_energy")
    q, direction = random(2, grad=False), random(2, grad=False, seed=1)
    with forward.dual_level():
        change = forward.unpack_dual(f(forward.make_dual(q, direction))).tangent
    expected = fb.gravity_torque(fb.load("2R"), q.numpy()) @ direction.numpy()
    np.testing.assert_allclose(change.item(), expected, rtol=1e-12)


def test_numbers_of_the_robot_are_differentiated_by_name():
    model = fb.load("2R")
    f = fb.to_torch(model, "inverse_dynamics", inputs=["link*.mass", "gravity"])
    q = random(2, grad=False)
    mass = torch.tensor([1.0, 2.0, 4.0], dtype=torch.float64, requires_grad=True)
    tau = f(q, 0.0 * q, 0.0 * q, p={"link2.mass": mass})
    assert tau.shape == (3, 2)
    tau.sum().backward()
    grown = fb.inverse_dynamics(model.bind({"link2.mass": 2.0}), q.numpy(), [0, 0], [0, 0])
    np.testing.assert_allclose(tau[1].detach().numpy(), grown, rtol=1e-12)
    lighter = fb.inverse_dynamics(model.bind({"link2.mass": 1.0}), q.numpy(), [0, 0], [0, 0])
    np.testing.assert_allclose(
        mass.grad.numpy(), [(grown - lighter).sum()] * 3, rtol=1e-9
    )  # linear in it
    plain = fb.inverse_dynamics(model, q.numpy(), [0, 0], [0, 0])
    np.testing.assert_allclose(f(q, 0.0 * q, 0.0 * q).numpy(), plain, rtol=1e-12)
    given = f(q, 0.0 * q, 0.0 * q, p=torch.from_numpy(f.values.copy()))
    np.testing.assert_allclose(given.numpy(), plain, rtol=1e-12)
    assert f(q.float(), q.float(), q.float()).dtype == torch.float32
    with pytest.raises(FreebodyError, match="not an input of this kernel"):
        f(q, q, q, p={"link1.com.x": 1.0})
    with pytest.raises(KernelError, match="no numbers of the model as inputs"):
        fb.to_torch(model, "bias")(q, q, p=mass)
    symbolic = fb.planar("RR")
    unknown = fb.to_torch(
        symbolic,
        "inverse_dynamics",
        inputs=[x.name for x in fb.parameters(symbolic) if not x.limit],
    )
    with pytest.raises(MissingValueError):
        unknown(q, q, q)


# ---------------------------------------------------------------- graphs
@pytest.mark.sample(1)
@pytest.mark.parametrize("backend", ["eager", "aot_eager"])
def test_in_a_compiled_function(backend):
    from torch.func import vmap

    f = fb.to_torch(fb.load("2R"), "inverse_dynamics")
    q, qd, qdd = random(4, 2), random(4, 2, grad=False, seed=1), random(2, grad=False, seed=2)

    def loss(q, qd, qdd):
        return f(2.0 * q, qd, qdd).square().sum()

    compiled = torch.compile(loss, backend=backend, fullgraph=True)
    value = loss(q, qd, qdd)
    assert compiled(q, qd, qdd).item() == value.item()
    (expected,) = torch.autograd.grad(value, q)
    (found,) = torch.autograd.grad(compiled(q, qd, qdd), q)
    np.testing.assert_array_equal(found.numpy(), expected.numpy())
    mapped = torch.compile(vmap(f, (0, 0, None)), backend=backend, fullgraph=True)(q, qd, qdd)
    np.testing.assert_array_equal(mapped.detach().numpy(), f(q, qd, qdd).detach().numpy())
    torch._dynamo.reset()


def test_in_an_exported_program():
    class Plant(torch.nn.Module):
        def __init__(self):
            super().__init__()
            self.step = fb.to_torch(fb.load("2R"), "semi_implicit_step")

        def forward(self, q, qd, tau):
            return self.step(q, qd, tau, 0.01)

    given = [random(5, 2, grad=False, seed=s) for s in range(3)]
    plant = Plant()
    batch = torch.export.Dim("batch")
    program = torch.export.export(plant, tuple(given), dynamic_shapes=[{0: batch}] * 3)
    assert "freebody.evaluate" in program.graph_module.code
    expected = plant(*[x[:3] for x in given])
    del plant  # a graph has nothing but the key
    gc.collect()
    made = program.module()(*[x[:3] for x in given])
    np.testing.assert_array_equal(torch.stack(made).numpy(), torch.stack(expected).numpy())
    with pytest.raises(
        KernelError, match=r"call fb\.to_torch with the same arguments as for the graph"
    ):
        torch.ops.freebody.evaluate("inverse_dynamics cpu float64 0123", given)


def test_the_longer_ways_give_the_same(monkeypatch):
    """Taken in a PyTorch that does not tell whether a transform is under way."""
    from freebody.targets import torch_operator

    f = fb.to_torch(fb.load("2R"), "inverse_dynamics")
    given = [random(3, 2, seed=s) for s in range(3)]
    expected = f(*given)
    slopes = torch.autograd.grad(expected.square().sum(), given)
    monkeypatch.setattr(torch_operator, "_watched", lambda: True)
    monkeypatch.setattr(torch_operator, "_graphed", lambda: True)
    np.testing.assert_array_equal(f(*given).detach().numpy(), expected.detach().numpy())
    for found, slope in zip(
        torch.autograd.grad(f(*given).square().sum(), given), slopes, strict=True
    ):
        np.testing.assert_array_equal(found.numpy(), slope.numpy())


def test_in_a_traced_graph():
    from torch.fx.experimental.proxy_tensor import make_fx

    f = fb.to_torch(fb.load("2R"), "inverse_dynamics")
    given = [random(3, 2, grad=False, seed=s) for s in range(3)]
    traced = make_fx(f)(*given)
    assert "freebody.evaluate" in traced.code
    other = [x + 1.0 for x in given]
    np.testing.assert_array_equal(traced(*other).numpy(), f(*other).numpy())


def test_the_operator_passes_pytorchs_own_tests():
    f = fb.to_torch(fb.load("2R"), "inverse_dynamics")
    given = [random(3, 2, seed=s) for s in range(3)]
    done = torch.library.opcheck(
        torch.ops.freebody.evaluate.default, (f._of[torch.float64].key, given)
    )
    assert set(done.values()) == {"SUCCESS"}


@pytest.mark.parametrize("where", range(3))
def test_of_tensors_without_numbers_come_shapes(where):
    f, given = (
        fb.to_torch(fb.load("2R"), "inverse_dynamics"),
        [random(5, 2, grad=False) for _ in range(3)],
    )
    given[where] = given[where].to("meta")
    made = f(*given)
    assert made.is_meta
    assert made.shape == (5, 2)


def test_names_of_strangers_are_in_no_graph(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    model = hostile()
    f = fb.to_torch(
        model, "inverse_dynamics", inputs=["*.mass"], wrench_frames=[model.frames[1].name]
    )

    class Arm(torch.nn.Module):
        def forward(self, *state):
            return f(*state)

    given = [random(*x.shape, grad=False) for x in f.program.inputs]
    text = str(torch.export.export(Arm(), tuple(given)))
    assert "evaluate" in text
    assert not [name for name in (*JOINTS, *LINKS[1:], model.name) if name in text]
    assert f._of[torch.float64].key.replace(" ", "_").isidentifier()


# ---------------------------------------------------------------- use
def test_a_gradient_through_a_rollout():
    """A hundred steps of RK4 under a linear law: the gradient by its gains, against differences."""
    model = fb.load("2R")
    step = fb.to_torch(model, "rk4_step")

    def cost(gains):
        q = torch.tensor([0.5, -0.3], dtype=torch.float64)
        qd = torch.zeros(2, dtype=torch.float64)
        total = 0.0
        for _ in range(100):
            q, qd = step(q, qd, -gains[0] * q - gains[1] * qd, 0.01)
            total = total + (q * q).sum()
        return total

    gains = torch.tensor([30.0, 5.0], dtype=torch.float64, requires_grad=True)
    cost(gains).backward()
    with torch.no_grad():
        for k, h in ((0, 1e-4), (1, 1e-4)):
            moved = torch.zeros(2, dtype=torch.float64)
            moved[k] = h
            difference = (cost(gains + moved) - cost(gains - moved)) / (2 * h)
            np.testing.assert_allclose(gains.grad[k].item(), difference.item(), rtol=1e-6)


def test_threads():
    f = fb.to_torch(fb.load("2R"), "forward_dynamics")

    def slope(seed):
        q = random(200, 2, seed=seed)
        f(q, 0.0 * q.detach(), 0.0 * q.detach()).sum().backward()
        return q.grad.numpy()

    expected = [slope(s) for s in range(8)]
    with ThreadPoolExecutor(4) as pool:
        for found, known in zip(pool.map(slope, range(8)), expected, strict=True):
            np.testing.assert_array_equal(found, known)


def test_copies_and_pickles():
    f = fb.to_torch(fb.load("2R"), "inverse_dynamics", inputs=["gravity"])
    q = random(2, grad=False)
    for other in (copy.deepcopy(f), pickle.loads(pickle.dumps(f))):
        np.testing.assert_array_equal(
            other(q, q, q, p={"gravity": 1.6}).numpy(), f(q, q, q, p={"gravity": 1.6}).numpy()
        )


def test_a_tensor_that_is_changed_before_its_gradient_is_refused():
    f = fb.to_torch(fb.load("2R"), "gravity_torque")
    q = random(2)
    x = q * 1.0
    y = f(x).sum()
    with torch.no_grad():
        x += 1.0
    with pytest.raises(RuntimeError, match="modified by an inplace operation"):
        y.backward()


# ---------------------------------------------------------------- what is refused
def test_refusals():
    model = fb.load("2R")
    f = fb.to_torch(model, "inverse_dynamics")
    q = random(2, grad=False)
    for given, error, words in (
        ((q, q), KernelError, "2 arguments given, expected 3: q"),
        ((q, q, random(3)), ShapeError, "qdd has shape"),
        ((random(2, 2), random(3, 2), q), BatchError, "do not broadcast"),
        ((q.numpy(), q, q), FreebodyError, "expected a tensor. torch.as_tensor makes one"),
        ((q.half(), q, q), KernelError, "torch.float16; kernels compute with"),
        ((q.int(), q, q), KernelError, "torch.int32"),
        ((True, q, q), FreebodyError, "expected a tensor"),
        ((q, q.to_sparse(), q), KernelError, "not a plain array: .*[Ss]parse"),
    ):
        with pytest.raises(error, match=words):
            f(*given)
    with pytest.raises(KernelError, match="kernels run on the CPU"):
        f._tensor(
            type("Far", (torch.Tensor,), {"is_cpu": False, "device": "cuda:0"})(q), torch.float64
        )
    with pytest.raises(KernelError, match="'float64' or 'float32'"):
        fb.to_torch(model, "bias", dtype="float16")
    with pytest.raises(FreebodyError, match="has its quantities already"):
        fb.to_torch(fb.kernel(model, "bias"), "bias")
    with pytest.raises(FreebodyError, match="give the quantities"):
        fb.to_torch(model)
    far = fb.kernel(model, "bias", target="numpy")
    far.target = "cuda"
    with pytest.raises(FreebodyError, match="not on target 'cuda'"):
        fb.to_torch(far)
    far.target = "numpy"  # others may be given this kernel too
    assert torch.isnan(f(q, q, torch.tensor([1.0, torch.nan]))).all()


def test_any_target_in_the_hosts_memory_is_called(monkeypatch):
    """Its record says so, no list of names."""
    monkeypatch.setitem(TARGETS, "of_tomorrow", TARGETS["numpy"])
    plain = fb.kernel(fb.load("2R"), "bias", target="numpy")
    q = random(2, grad=False)
    found = fb.to_torch(Kernel(plain.program, "of_tomorrow", 1, plain.ufunc))(q, q)
    np.testing.assert_array_equal(found, plain(q.numpy(), q.numpy()))
