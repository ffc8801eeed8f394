"""Finds the cheapest settings of one engine in this process: python one.py ENGINE N SECONDS OPTIONS FILE.

OPTIONS is JSON, with what engines need to find their programs. FILE gets the result.
"""

import importlib
import json
import resource
import statistics
import sys
from pathlib import Path

import sheet

LONGEST = 60.0  # of a run [s]
RUNS = 3  # of which the median counts
PATIENCE = 8  # a search ends after so many settings in a row that took too long, as settings get dearer


def main():
    name, n, seconds, options, file = sys.argv[1:]
    engine = importlib.import_module(name)
    heights = json.loads(Path(__file__).with_name("reference.json").read_text())
    search = Search(engine, int(n), heights, json.loads(options))
    methods = [search.method(method, settings, float(seconds)) for method, settings in engine.methods(int(n)).items()]
    result = {"engine": engine.NAME, "version": engine.version(search.options), "n": int(n), "methods": methods}
    Path(file).write_text(json.dumps(result))


class Search:
    def __init__(self, engine, n, heights, options):
        self.engine, self.n, self.heights, self.options = engine, n, heights, options

    def run(self, settings, limit):
        return self.engine.swing(sheet.Swing(self.n, self.heights), settings, limit, self.options)

    def method(self, method, candidates, seconds):
        """Tries all settings, within so many `seconds` of CPU time. A run may take no longer than one that was good enough for every level."""
        best, tried, slow, start = {}, [], 0, spent()
        for settings in candidates:
            if spent() - start > seconds:
                tried.append({"settings": settings, "outcome": f"not tried, and none after it: {seconds:.0f} s are over"})
                break
            strictest = best.get(min(sheet.LEVELS))
            limit = min(LONGEST, 1.3 * strictest[1].cpu) if strictest else LONGEST
            try:
                run = self.run(settings, limit)
            except sheet.Missing as why:
                return {"method": method, "levels": {}, "failure": str(why)}
            except sheet.Stopped as why:
                tried.append({"settings": settings, "outcome": str(why)})
                slow = slow + 1 if isinstance(why, sheet.TooSlow) else 0
                if slow == PATIENCE:
                    break
            else:
                slow = 0
                tried.append({"settings": settings, "outcome": brief(run)})
                for level in sheet.LEVELS:
                    if max(run.stretch) <= level and (level not in best or run.cpu < best[level][1].cpu):
                        best[level] = settings, run
            print(f"{self.engine.NAME}, {method}, {tried[-1]['settings']}: {tried[-1]['outcome']}", file=sys.stderr, flush=True)
        levels = {str(level): self.again(*best[level]) for level in best}
        strict, loose = (levels.get(str(level)) for level in sheet.LEVELS)
        if strict and strict["cpu_ms"] < loose["cpu_ms"]:
            levels[str(max(sheet.LEVELS))] = strict  # what is good enough for the one is for the other
        return {"method": method, "levels": levels, "tried": tried}

    def again(self, settings, run):
        """The median of several runs."""
        runs = [run] + [self.run(settings, 2 * LONGEST) for _ in range(RUNS - 1)]
        return {
            "settings": settings,
            "cpu_ms": statistics.median(1e3 * run.cpu for run in runs),
            "wall_ms": statistics.median(1e3 * run.wall for run in runs),
            "stretch": max(run.stretch),
            "height_half": run.heights[sheet.FRAMES // 2],
            "height_end": run.heights[-1],
            "off": run.off(),
        }


def spent():
    """CPU time of this process and of the programs that it ran [s]."""
    both = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(usage.ru_utime + usage.ru_stime for usage in both)


def brief(run):
    return f"stretch {100 * max(run.stretch):.2f} %, mean height off by {1e3 * run.off():.0f} mm, {1e3 * run.cpu:.0f} ms"


if __name__ == "__main__":
    main()
