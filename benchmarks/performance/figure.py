"""What draws pictures into files. A benchmark that lacks it says so before it
measures, and is asked for --help without it: it imports this late."""
import packages

try:
    import matplotlib
    import numpy as np

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
except ImportError as error:
    raise SystemExit(f"{error}: {packages.REMEDY}") from error
