"""All stages of tools/gpu_check, their records, and the report on them."""
import json
import shlex
import subprocess
import time

from builds import Builds
from call import ROOT, Failure, table
from comparisons import Comparisons
from measurements import Measurements

STAGES = ["device", "setup", "build", "test", "scenes", "cases", "speed",
          "kernels", "sweep", "profile"]


class Check(Builds, Comparisons, Measurements):
    """One call. Each stage is a method that returns what it found, which its
    record keeps: {"text": lines of Markdown, "failed": texts, ...}."""

    def perform(self, stage):
        """Runs a stage and keeps its record. Returns whether it has passed."""
        print(f"gpu_check: {stage}", flush=True)
        self.log = self.cleared(f"{stage}.log")
        start = time.monotonic()
        try:
            found = getattr(self, stage)()
        # Whatever it is, the next stage is run; a benchmark's reader may exit.
        except (Exception, SystemExit) as error:
            found = {"text": [], "failed": [
                str(error) if isinstance(error, Failure) else repr(error)]}
        found.setdefault("failed", [])
        record = {"stage": stage, "passed": not found["failed"],
                  "seconds": time.monotonic() - start,
                  "finished": time.strftime("%Y-%m-%d %H:%M:%S"),
                  "revision": self.revision(), "preset": self.options.preset,
                  "reference": self.options.reference,
                  "quick": self.options.quick, "set": self.options.set, **found}
        if not self.options.dry_run:
            (self.output / f"{stage}.json").write_text(
                json.dumps(record, indent=1))
        for text in found["failed"]:
            print(f"  failed: {text}")
        if found.get("but"):
            print(f"  but {found['but']}")
        return record["passed"]

    @staticmethod
    def revision():
        try:
            found = subprocess.run(["git", "describe", "--always", "--dirty"],
                                   cwd=ROOT, capture_output=True, text=True)
        except FileNotFoundError: # no git
            return "unknown"
        return found.stdout.strip() or "unknown"

    def report(self):
        records = {stage: json.loads(path.read_text()) for stage in STAGES
                   if (path := self.output / f"{stage}.json").exists()}
        (self.output / "report.json").write_text(
            json.dumps(list(records.values()), indent=1))
        rows = []
        for stage in STAGES:
            if stage not in records:
                again = shlex.join(["tools/gpu_check", *self.options.others,
                                    "--stage", stage])
                rows.append([stage, f"not run: `{again}`", "", "", "", ""])
                continue
            r = records[stage]
            rows.append([stage, ("passed" if r["passed"] else "**failed**") +
                         (f", but {r['but']}" if r.get("but") else ""),
                         f"{r['preset']} against {r['reference']}",
                         f"{r['seconds']:.0f}", r["finished"],
                         r["revision"] + (", quick" if r["quick"] else "")])
        lines = ["# GPU check", "",
                 *table(["stage", "", "builds", "seconds", "finished",
                         "revision"], rows)]
        for stage, record in records.items():
            lines += ["", f"## {stage}", "",
                      *[f"- failed: {text}" for text in record["failed"]],
                      "", *record["text"]]
        (self.output / "report.md").write_text("\n".join(lines) + "\n")
        print(f"gpu_check: the report is {self.output / 'report.md'}")
