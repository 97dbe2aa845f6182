"""The processes that a launcher has started, and the end of a run that lost one."""
import pathlib
import subprocess


def children(pid):
    """The processes that a process has started."""
    path = pathlib.Path(f"/proc/{pid}/task/{pid}/children")
    return [int(child) for child in path.read_text().split()]


def has_ended(pid):
    """Is it gone, or does it only wait for its launcher to take notice?"""
    try:
        text = pathlib.Path(f"/proc/{pid}/stat").read_text()
    except OSError:
        return True
    return text.rpartition(")")[2].split()[0] == "Z"


def end(process, seconds=30):
    """Waits for the end of a run of which a rank was killed.

    Returns its standard output, and whether the launcher stayed behind without
    ranks, and so was killed: Open MPI 4.1.4 with PMIx 4.2.2 sometimes waits for a
    lock of its own then, in pmix_rte_finalize. Raises subprocess.TimeoutExpired
    where ranks did not end.
    """
    try:
        return process.communicate(timeout=seconds)[0], False
    except subprocess.TimeoutExpired:
        if not all(map(has_ended, children(process.pid))):
            raise
        process.kill()
        return process.communicate()[0], True
