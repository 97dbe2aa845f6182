"""How runs on several ranks are started."""
import os
import shlex
import shutil

# One thread each; Open MPI's ways to share cores and to run as root.
ENVIRONMENT = dict(os.environ, OMP_NUM_THREADS="1", OMP_PROC_BIND="false",
                   OMPI_MCA_rmaps_base_oversubscribe="1",
                   OMPI_ALLOW_RUN_AS_ROOT="1",
                   OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")


def find(parser, command):
    """Words of what --mpiexec names, such as "mpirun --bind-to none"."""
    words = shlex.split(command)
    if not words or not shutil.which(words[0]):
        parser.error(f"--mpiexec: {command!r} is no program")
    return words
