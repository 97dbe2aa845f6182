"""What the tests of this folder share: how they start programs, wait for them, and
what these answer."""

import os
import re
import subprocess
import time

FINISHED, NUMERICAL_FAILURE, WRONG_INPUT, STOPPED_EARLY, IO_FAILURE = range(5)

# Open MPI's ways to share cores and to run as root; others ask for neither.
OPEN_MPI = {"OMPI_MCA_rmaps_base_oversubscribe": "1",
            "OMPI_MCA_mpi_yield_when_idle": "1",
            "OMPI_ALLOW_RUN_AS_ROOT": "1",
            "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
# Kokkos warns when threads are not bound; that is not under test.
ENVIRONMENT = {**os.environ, **OPEN_MPI, "OMP_PROC_BIND": "false"}
ONE_THREAD = {**ENVIRONMENT, "OMP_NUM_THREADS": "1"}

# What a user never sees, from an uncaught exception to a sanitizer's report.
ALARMING = re.compile(
    r"terminate|what\(\)|abort|exception|core dumped|Kokkos|runtime error"
    r"|Sanitizer|Segmentation|assert", re.IGNORECASE)


def start(test, command, environment):
    """A process, which does not outlive the test."""
    process = subprocess.Popen(list(map(str, command)), env=environment,
                               stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                               stderr=subprocess.PIPE, text=True)

    def finish():
        process.kill()
        process.communicate()

    test.addCleanup(finish)
    return process


def wait_for(test, process, count, folder, pattern):
    """Until there are so many files."""
    deadline = time.monotonic() + 60
    while len(list(folder.glob(pattern))) < count:
        test.assertIsNone(process.poll(), "the run has ended by itself")
        test.assertLess(time.monotonic(), deadline, f"no {pattern}")
        time.sleep(0.005)
