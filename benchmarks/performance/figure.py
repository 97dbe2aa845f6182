"""What draws pictures into files. A benchmark that lacks it says so before it
measures."""
try:
    import matplotlib
    import numpy as np

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
except ImportError as error:
    raise SystemExit(
        f"{error}; the picture needs numpy and matplotlib (Debian: apt-get install "
        "python3-numpy python3-matplotlib, then run it with /usr/bin/python3)"
    ) from error
