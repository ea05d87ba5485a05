"""A Debian system with Blender in a directory: set up once, then run in name spaces of its own.

Each run's mounts, processes, X server and temporary files end with it, however it ends, and it has
no network. The project is visible inside at its usual path. The home directory is empty at every
start.
"""

from __future__ import annotations

import fcntl
import os
import shlex
import shutil
import subprocess
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

PROJECT = Path(__file__).resolve().parent.parent
CACHE_VARIABLE = "REAL_BLENDER_CACHE"
TIMED_OUT = 124  # the exit code of coreutils' timeout

PACKAGES = (
    "blender", "python3-scipy", "xvfb", "libgl1-mesa-dri", "libegl1", "x11-utils", "xdotool",
    "imagemagick",
)  # fmt: skip
# Modules that sid's Blender imports at its start without depending on their packages.
EXTRA_PACKAGES = {"sid": ("python3-cattr", "python3-requests", "python3-zstandard")}

# Everything that is started ends with this process, even if it is killed.
NAMESPACES = (
    "setpriv", "--pdeathsig", "KILL",
    "unshare", "--mount", "--pid", "--ipc", "--fork", "--kill-child",
)  # fmt: skip


class SetupError(Exception):
    """The chroot cannot be made or used here; the message says why in one line."""


@dataclass(frozen=True)
class Chroot:
    """A Debian system in a directory, and the marks that say how far its set-up got.

    Attributes
    ----------
    root : Path
        Directory of the system.
    suite : str
        Debian release, for instance ``"trixie"``.
    """

    root: Path
    suite: str

    @property
    def packages(self) -> tuple[str, ...]:
        """Packages that the system must have."""
        return PACKAGES + EXTRA_PACKAGES.get(self.suite, ())

    @property
    def owner_mark(self) -> Path:
        """Present in every directory that this script made, and may therefore delete."""
        return self.root / ".real-blender"

    @property
    def base_mark(self) -> Path:
        """Present once the base system is complete."""
        return self.root / ".real-blender-base"

    @property
    def packages_mark(self) -> Path:
        """Present once the packages are installed; holds their names."""
        return self.root / ".real-blender-packages"

    def is_ready(self) -> bool:
        """Tell whether the set-up has been finished for the packages wanted today."""
        mark = self.packages_mark
        return mark.exists() and mark.read_text().split() == list(self.packages)


def locate(suite: str, cache: Path | None = None) -> Chroot:
    """Chroot of `suite` in `cache`, else in the environment's directory, else in the user's."""
    if cache is None and (named := os.environ.get(CACHE_VARIABLE)):
        cache = Path(named)
    if cache is None:
        cache = Path.home() / ".cache/adaptive-fairing/real-blender" / suite
    return Chroot(cache.expanduser().resolve(), suite)


def set_up(chroot: Chroot) -> None:
    """Make the chroot, or finish what an earlier, interrupted set-up has left.

    Raises
    ------
    SetupError
        Without root rights or outside Debian, or when a package cannot be installed.
    """
    if chroot.is_ready():
        return
    require_debian_root()
    with locked(chroot.root.with_name(chroot.root.name + ".lock")):
        if chroot.is_ready():  # another process did it while this one waited
            return
        tools = ["debootstrap", "debian-archive-keyring"]
        check(["apt-get", "update", "-q"], "apt-get update failed")
        command = ["apt-get", "install", "-y", "-q", "--no-install-recommends", *tools]
        check(command, f"apt-get could not install {' and '.join(tools)}")
        if not chroot.base_mark.exists():
            bootstrap(chroot)
        install_packages(chroot)


def require_debian_root() -> None:
    """Raise `SetupError` unless this is root on a system with apt."""
    if os.geteuid() != 0:
        raise SetupError("needs root for the chroot: run it with sudo")
    if shutil.which("apt-get") is None:
        raise SetupError("needs Debian or Ubuntu (apt-get and debootstrap are missing here)")


@contextmanager
def locked(path: Path) -> Iterator[None]:
    """Hold an exclusive lock on the file `path`, so that only one process sets up."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def bootstrap(chroot: Chroot) -> None:
    """Make the base system from nothing."""
    if chroot.owner_mark.exists():
        shutil.rmtree(chroot.root)  # half a base system cannot be completed, only made again
    elif chroot.root.exists() and any(chroot.root.iterdir()):
        raise SetupError(f"{chroot.root} is not empty and was not made by this script")
    chroot.root.mkdir(parents=True, exist_ok=True)
    chroot.owner_mark.touch()
    command = ["debootstrap", "--variant=minbase", chroot.suite, str(chroot.root)]
    check([*NAMESPACES, "--mount-proc", *command], f"debootstrap of {chroot.suite} failed")
    chroot.base_mark.touch()


def install_packages(chroot: Chroot) -> None:
    """Install Blender and its helpers; an interrupted installation is completed."""
    # Services must not start in a chroot; exit code 101 of this hook tells dpkg so.
    policy = chroot.root / "usr/sbin/policy-rc.d"
    policy.write_text("#!/bin/sh\nexit 101\n")
    policy.chmod(0o755)
    resolver = Path("/etc/resolv.conf")
    if resolver.exists():
        (chroot.root / "etc/resolv.conf").write_text(resolver.read_text())
    # The host's proxy and its policy about old indexes hold inside too.
    acquire = subprocess.run(["apt-config", "dump", "Acquire"], capture_output=True, check=True)
    (chroot.root / "etc/apt/apt.conf.d/99host").write_bytes(acquire.stdout)
    install = f"apt-get install -y -q --no-install-recommends {' '.join(chroot.packages)}"
    script = f"""
        set -e
        export DEBIAN_FRONTEND=noninteractive
        dpkg --configure -a
        apt-get update -q
        apt-get -o Acquire::Retries=3 install -y -q -f
        {install}
        apt-get clean
    """
    code = run_inside(chroot, script, network=True)
    if code != 0:
        raise SetupError(f"apt-get could not install Blender in {chroot.root} (exit code {code})")
    unfinished = chroot.packages_mark.with_suffix(".new")
    unfinished.write_text("\n".join(chroot.packages))
    unfinished.replace(chroot.packages_mark)


def check(command: Sequence[str], failure: str) -> None:
    """Run `command` and raise `SetupError` with the text `failure` unless it exits with 0."""
    if subprocess.run(command, check=False, stdin=subprocess.DEVNULL).returncode != 0:
        raise SetupError(failure)


def run_inside(
    chroot: Chroot,
    script: str,
    *,
    binds: Sequence[Path] = (),
    environment: dict[str, str] | None = None,
    network: bool = False,
    timeout: float | None = None,
) -> int:
    """Run a shell script in the chroot and wait for its end.

    Parameters
    ----------
    chroot : Chroot
        Where to run.
    script : str
        For ``sh -c``, started in the project's directory. It is the last of its process name
        space: nothing outlives it.
    binds : sequence of Path
        Host directories that appear inside at the same path, writable.
    environment : dict, optional
        Added to a small fixed environment; nothing else is inherited from the host.
    network : bool
        Whether the script may use the host's network.
    timeout : float, optional
        Seconds after which everything inside is ended.

    Returns
    -------
    int
        Exit code of the script, or `TIMED_OUT`.
    """
    variables = {
        "HOME": "/tmp/home",
        "PATH": "/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin",
        "LC_ALL": "C.UTF-8",
        "DISPLAY": ":0",
        "LIBGL_ALWAYS_SOFTWARE": "1",
        # The software renderer compiles its shaders for seconds: keep them between runs.
        "MESA_SHADER_CACHE_DIR": "/var/cache/mesa",
        **(environment or {}),
    }
    settings = [shlex.quote(f"{name}={value}") for name, value in variables.items()]
    root = shlex.quote(str(chroot.root))
    lines = [
        "set -e",
        f"mount --rbind /dev {root}/dev",
        f"mount -t proc proc {root}/proc",
        f"mount -t tmpfs tmpfs {root}/tmp",
        f"mkdir -p {root}/tmp/home {root}/var/cache/mesa",
    ]
    for path in (PROJECT, *binds):
        outside, inside = shlex.quote(str(path)), shlex.quote(f"{chroot.root}{path}")
        lines += [f"mkdir -p {inside}", f"mount --bind {outside} {inside}"]
    # Not exec: as process 1 itself, a program would not die from its own abort().
    script = f"cd {shlex.quote(str(PROJECT))}\n{script}"
    command = f"chroot {root} env -i {' '.join(settings)} sh -c {shlex.quote(script)}"
    lines += ["set +e", command, "exit $?"]
    # Without the host's network, X display numbers are private to this run as well.
    alone = () if network else ("--net",)
    outer = [*NAMESPACES, *alone, "sh", "-c", "\n".join(lines)]
    try:
        return subprocess.run(
            outer, check=False, timeout=timeout, stdin=subprocess.DEVNULL
        ).returncode
    except subprocess.TimeoutExpired:
        return TIMED_OUT
