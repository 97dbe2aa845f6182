"""What tools and benchmarks answer before they do anything."""

import pathlib
import subprocess
import tempfile
import unittest

TOOLS = pathlib.Path(__file__).resolve().parent.parent / "tools"


class Help(unittest.TestCase):

    def test_it_is_the_comment_at_the_top(self):
        for name in ["setup", "run", "test", "gpu_check"]:
            source = (TOOLS / name).read_text().splitlines()
            comment = source[1:next(k for k, line in enumerate(source)
                                    if not line.startswith("#"))]
            for arguments in [["--help"], ["-h"], ["something", "--help"]]:
                with self.subTest(tool=name, arguments=arguments), \
                        tempfile.TemporaryDirectory() as empty:
                    # With no more on the PATH than that, nothing could be built.
                    for word in ["bash", "dirname", "nproc", "sed"]:
                        program = subprocess.run(["which", word], check=True, text=True,
                                                 capture_output=True).stdout.strip()
                        (pathlib.Path(empty) / word).symlink_to(program)
                    result = subprocess.run(
                        [pathlib.Path(empty) / "bash", TOOLS / name, *arguments],
                        env={"PATH": empty}, capture_output=True, text=True, timeout=20)
                    self.assertEqual(result.returncode, 0, result.stderr)
                    self.assertEqual(result.stderr, "")
                    self.assertEqual(
                        result.stdout.splitlines(),
                        [line.removeprefix("#").removeprefix(" ") for line in comment])


if __name__ == "__main__":
    unittest.main()
