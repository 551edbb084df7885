"""The set-up's decisions, on samples: which apt entry gives the backports, what is missing, how it fails."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


def shell(script, expect=0, **variables):
    """Run a script after sourcing scripts/setup.sh."""
    result = subprocess.run(
        ["bash", "-c", f". {ROOT}/scripts/setup.sh; {script}"],
        text=True,
        capture_output=True,
        env=os.environ | {k: str(v) for k, v in variables.items()},
        timeout=60,
    )
    assert result.returncode == expect, result.stderr
    return result


def backports(folder):
    return shell("backports_entry bookworm", RESTIRPG_APT_FOLDER=folder).stdout


@pytest.fixture
def apt(tmp_path):
    (tmp_path / "sources.list.d").mkdir()
    return tmp_path


def test_one_line_entry_keeps_mirror_and_options(apt):
    (apt / "sources.list").write_text(
        "# deb http://commented.example/debian bookworm main\n"
        "deb cdrom:[Debian 12]/ bookworm main\n"
        "deb http://mirror.example/security bookworm-security main\n"
        "deb [arch=amd64 signed-by=/usr/share/keyrings/a.gpg] http://mirror.example/debian bookworm main contrib\n"
    )
    assert backports(apt) == (
        "list\ndeb [arch=amd64 signed-by=/usr/share/keyrings/a.gpg] "
        "http://mirror.example/debian bookworm-backports main\n"
    )


def test_deb822_entry_keeps_mirror_and_keyring(apt):
    (apt / "sources.list.d/debian.sources").write_text(
        "Types: deb\nURIs: http://mirror.example/security\nSuites: bookworm-security\nComponents: main\n"
        "\n"
        "Types: deb deb-src\n# http://commented.example/\nURIs: http://mirror.example/debian\n"
        "Suites: bookworm bookworm-updates\nComponents: main contrib\nSigned-By: /usr/share/keyrings/a.gpg\n"
    )
    assert backports(apt) == (
        "sources\nTypes: deb\nURIs: http://mirror.example/debian\nSuites: bookworm-backports\n"
        "Components: main\nSigned-By: /usr/share/keyrings/a.gpg\n"
    )


def test_deb822_files_are_not_run_together(apt):
    (apt / "sources.list.d/a.sources").write_text(
        "Types: deb\nURIs: http://other.example/\nSuites: nodistro\nComponents: main\nSigned-By: /b.gpg\n"
    )
    (apt / "sources.list.d/debian.sources").write_text(
        "Types: deb\nURIs: http://mirror.example/debian\nSuites: bookworm\nComponents: main\n"
    )
    assert backports(apt) == (
        "sources\nTypes: deb\nURIs: http://mirror.example/debian\nSuites: bookworm-backports\nComponents: main\n"
    )


def test_deb822_entry_keeps_an_embedded_key(apt):
    key = "Signed-By:\n -----BEGIN PGP PUBLIC KEY BLOCK-----\n .\n abc\n -----END PGP PUBLIC KEY BLOCK-----\n"
    (apt / "sources.list.d/debian.sources").write_text(
        f"Types: deb\nURIs: http://mirror.example/debian\nSuites: bookworm\nComponents: main\n{key}"
    )
    assert backports(apt).endswith(f"Suites: bookworm-backports\nComponents: main\n{key}")


@pytest.mark.parametrize("component", ["stable", "main"])
def test_other_vendors_entries_of_the_suite_are_passed_over(apt, component):
    (apt / "sources.list.d/azure.sources").write_text(
        f"Types: deb\nURIs: https://vendor.example/repos/tool/\nSuites: bookworm\nComponents: {component}\n"
    )
    (apt / "sources.list.d/docker.sources").write_text(
        "Types: deb\nURIs: https://vendor.example/linux/debian\nSuites: bookworm\nComponents: stable\n"
    )
    (apt / "sources.list").write_text(
        f"deb https://vendor.example/debian/12/prod bookworm {component}\n"
        "deb https://vendor.example/linux/debian bookworm stable\n"
        "deb http://mirror.example/debian/ bookworm contrib main non-free\n"
    )
    assert backports(apt) == "list\ndeb http://mirror.example/debian/ bookworm-backports main\n"


def test_a_mirror_at_any_address_will_do(apt):
    (apt / "sources.list").write_text("deb http://mirror.example/apt bookworm main\n")
    assert backports(apt) == "list\ndeb http://mirror.example/apt bookworm-backports main\n"


def test_an_entry_that_apt_cannot_read_does_not_stay(apt):
    (apt / "sources.list").write_text("deb http://mirror.example/debian bookworm main\n")
    failing = 'as_root() { if [[ $1 == apt-get ]]; then stop "failed: $*"; else "$@"; fi; }; add_backports bookworm'
    result = shell(failing, expect=2, RESTIRPG_APT_FOLDER=apt)
    assert "failed: apt-get" in result.stderr and not list((apt / "sources.list.d").iterdir())


def test_entries_that_are_off_or_of_another_suite_are_passed_over(apt):
    (apt / "sources.list.d/a.sources").write_text(
        "Enabled: no\nTypes: deb\nURIs: http://off.example/debian\nSuites: bookworm\nComponents: main\n"
    )
    (apt / "sources.list.d/b.sources").write_text(
        "Types: deb-src\nURIs: http://source.example/debian\nSuites: bookworm\nComponents: main\n"
    )
    (apt / "sources.list").write_text("deb http://mirror.example/debian trixie main\n")
    assert backports(apt) == ""


def test_no_apt_entry_is_one_clear_line(apt):
    result = shell("add_backports bookworm", expect=2, RESTIRPG_APT_FOLDER=apt)
    assert result.stderr == (
        "setup: no apt entry of suite bookworm to take a mirror from; "
        "add the suite bookworm-backports and start again\n"
    )


def test_missing_packages_are_named_among_installed_ones():
    assert (
        shell("printf 'dpkg\\nrestirpg-no-such-package\\nbash\\n' | not_installed").stdout
        == "restirpg-no-such-package\n"
    )


def test_the_browser_is_for_the_tests_only():
    assert "chromium" not in shell("package_names build").stdout.split()
    assert "chromium" in shell("package_names tests").stdout.split()


def test_other_systems_get_the_list_of_what_is_missing(tmp_path):
    """The probes of every listed package succeed here, where all are installed; an unknown one is named."""
    assert shell("check_elsewhere tests").stderr == ""
    (tmp_path / "scripts").mkdir()
    (tmp_path / "scripts/packages.txt").write_text(
        "bash command bash\nnosuch command restirpg-no-such-command\nnoheader header restirpg/none.h\n"
        "nomodule module restirpg_no_such_module\n"
    )
    result = shell(f"root={tmp_path}; check_elsewhere build", expect=2)
    assert result.stderr.endswith("then start again: nosuch noheader nomodule\n")
    assert len(result.stderr.splitlines()) == 1


def test_a_file_may_lie_elsewhere_on_other_systems(tmp_path):
    """The second pattern of clang's fuzzer library is that of Fedora and Arch; without a browser tests skip."""
    for folder in ("lib64/clang/17/lib/x86_64-redhat-linux-gnu", "lib/clang/17/lib/linux"):
        (tmp_path / folder).mkdir(parents=True)
    lines = (ROOT / "scripts/packages.txt").read_text().splitlines()
    [patterns] = (line.split()[2:] for line in lines if line.startswith("libclang-rt-dev "))
    (tmp_path / "lib64/clang/17/lib/x86_64-redhat-linux-gnu/libclang_rt.fuzzer.a").touch()
    (tmp_path / "lib/clang/17/lib/linux/libclang_rt.fuzzer-x86_64.a").touch()
    assert len([file for pattern in patterns for file in tmp_path.glob(pattern)]) == 2
    (tmp_path / "scripts").mkdir()
    (tmp_path / "scripts/packages.txt").write_text(
        "clang file share/restirpg-none/* bin/bash\nchromium command restirpg-no-such-command\n"
    )
    result = shell(f"root={tmp_path}; check_elsewhere tests")
    assert result.stderr == "setup: this system lacks chromium: tests that need it will skip\n"


def test_a_start_with_nothing_missing_calls_no_package_manager(tmp_path):
    """Programs that would touch the network are replaced by ones that fail."""
    for name in ("apt-get", "apt-cache", "sudo", "curl"):
        (tmp_path / name).write_text("#!/bin/sh\necho called >&2\nexit 1\n")
        (tmp_path / name).chmod(0o755)
    assert shell("install_packages tests", PATH=f"{tmp_path}:{os.environ['PATH']}").stderr == ""


ARCHIVE = """
mesa_is_old() { return 1; }; as_root() { :; }; apt_install() { echo "installs $*"; }; apt-cache() { echo "Package: bash"; }
"""


def test_an_archive_without_the_browser_is_no_obstacle():
    """Ubuntu's has none under Debian's name."""
    done = shell(
        ARCHIVE + "not_installed() { cat > /dev/null; printf 'bash\\nchromium\\n'; }; install_debian tests noble"
    )
    assert done.stdout == "installs bash\n" and "lacks chromium: tests that need it will skip" in done.stderr
    missing = ARCHIVE + "not_installed() { cat > /dev/null; printf 'bash\\nembree\\n'; }; install_debian tests noble"
    assert shell(missing, expect=2).stderr.endswith("archive lacks: embree\n")


@pytest.mark.parametrize("script", ["run", "test"])
def test_help_installs_and_builds_nothing(script, tmp_path):
    """With nothing on PATH that could."""
    for name in ("sed", "dirname", "bash"):
        (tmp_path / name).symlink_to(f"/usr/bin/{name}")
    done = subprocess.run(
        ["/bin/bash", ROOT / "scripts" / script, "--help"],
        text=True,
        capture_output=True,
        env={"PATH": str(tmp_path)},
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("Set up this machine, build")
    assert "#" not in done.stdout.replace("#!", "") and "shellcheck" not in done.stdout


@pytest.fixture
def clone(tmp_path):
    """A folder with the set-up alone. call(script): the finished process of a script that sources it, with stand-ins for
    cmake, ninja and ctest: the first says which build type it was given, the last what $CTEST says."""
    clone, stubs = tmp_path / "clone", tmp_path / "stubs"
    for folder in (clone / "scripts", stubs):
        folder.mkdir(parents=True)
    for name in ("setup.sh", "test"):
        shutil.copy(ROOT / "scripts" / name, clone / "scripts")
    (stubs / "cmake").write_text(
        '#!/bin/bash\nmkdir -p "$5"; touch "$5/build.ninja"\n'
        'printf "CMAKE_HOME_DIRECTORY:INTERNAL=%s\\nCMAKE_CACHEFILE_DIR:INTERNAL=%s\\n" "$3" "$5" > "$5/CMakeCache.txt"\n'
        'echo "CMAKE_BUILD_TYPE:STRING=Release" >> "$5/CMakeCache.txt"\n'
        "echo configured\n"
    )
    (stubs / "ninja").write_text("#!/bin/bash\necho built\n")
    (stubs / "ctest").write_text('#!/bin/bash\necho "Total Tests: $CTESTS"\n')
    for stub in stubs.iterdir():
        stub.chmod(0o755)
    return clone


def call(clone, *command, **variables):
    """The finished process of a command, with the clone's stand-ins first on PATH."""
    stubs = {
        "PATH": f"{clone.parent / 'stubs'}:{os.environ['PATH']}",
        "MESA_SHADER_CACHE_DIR": str(clone.parent / "mesa"),
    }
    environment = os.environ | stubs | {"RESTIRPG_SKIP_SETUP": "1"} | variables
    return subprocess.run(command, text=True, capture_output=True, env=environment, cwd=clone.parent)


def build(clone, **variables):
    return call(clone, "bash", "-c", f". {clone}/scripts/setup.sh; build renderer", **variables)


def test_a_debug_build_is_not_timed(clone):
    build(clone)
    cache = clone / "build/CMakeCache.txt"
    cache.write_text(cache.read_text().replace("=Release", "=Debug"))
    done = build(clone)
    assert done.returncode == 2 and done.stderr.startswith(f"setup: {clone}/build: its build type is 'Debug'")
    assert len(done.stderr.splitlines()) == 1


def test_the_build_folder_may_be_another_one(clone):
    done = build(clone, RESTIRPG_BUILD="other")
    assert done.returncode == 0, done.stderr
    assert (clone.parent / "other/CMakeCache.txt").exists() and not (clone / "build").exists()
    told = call(clone, "bash", "-c", f". {clone}/scripts/setup.sh; echo $RESTIRPG_BUILD", RESTIRPG_BUILD="other").stdout
    assert told == f"{clone.parent}/other\n"


@pytest.fixture
def tests(clone):
    """The finished process of scripts/test with a pattern, where pytest has two tests and ctest as many as are said."""
    (clone / "test_two.py").write_text("def test_light():\n    pass\n\n\ndef test_glass():\n    pass\n")
    return lambda pattern, ctests: call(clone, clone / "scripts/test", pattern, CTESTS=str(ctests), PYTEST_ADDOPTS="")


def test_a_pattern_that_no_test_has_is_a_mistake(tests):
    done = tests("restirpg_no_such", 0)
    assert done.returncode == 2 and done.stderr.splitlines()[-1].startswith(
        "setup: no test is called 'restirpg_no_such'"
    )
    assert tests("restirpg_no_such", 1).returncode == 0
    assert tests("light", 0).returncode == 0


def test_a_pattern_of_alternatives_is_pytest_s_too(tests):
    done = tests("light|glass", 0)
    assert done.returncode == 0 and "2 passed" in done.stdout, done.stdout + done.stderr


def test_a_clone_that_was_copied_or_moved_is_configured_again(clone, tmp_path):
    def built(folder):
        return call(clone, "bash", "-c", f". {folder}/scripts/setup.sh; build renderer").stderr.split()

    assert built(clone) == ["configured", "built"]
    assert built(clone) == ["built"]
    subprocess.run(["cp", "-a", clone, tmp_path / "copy"], check=True)
    assert built(tmp_path / "copy") == ["configured", "built"]
    assert built(tmp_path / "copy") == ["built"]
    clone.rename(tmp_path / "moved")
    assert built(tmp_path / "moved") == ["configured", "built"]
