"""Reads the text format of Prometheus 0.0.4 as strictly as `promtool check metrics` does.

    families = prometheus.parse(text)     # {name: Family}
    families["x_total"].value(route="/")

Raises ValueError with the line that breaks a rule: names, escaping, HELP and TYPE once and before
their samples, no series twice, histograms complete, cumulative and ending in +Inf, counters named
_total, no counter below zero.
"""

import math
import re

NAME = re.compile(r"[a-zA-Z_:][a-zA-Z0-9_:]*\Z")
LABEL = re.compile(r"[a-zA-Z_][a-zA-Z0-9_]*\Z")
SAMPLE = re.compile(r"([a-zA-Z_:][a-zA-Z0-9_:]*)(\{.*\})? (\S+)\Z")
PAIR = re.compile(r'([a-zA-Z_][a-zA-Z0-9_]*)="((?:[^"\\\n]|\\\\|\\"|\\n)*)"(,|\Z)')
KINDS = {"counter", "gauge", "histogram"}


class Family:
    """A metric: its kind, help, and samples [(name, labels, value)]."""

    def __init__(self, name):
        self.name, self.kind, self.help, self.samples = name, None, None, []

    def values(self, suffix="", **labels):
        """Values of the samples that have these labels, perhaps among others."""
        return [value for name, own, value in self.samples
                if name == self.name + suffix and labels.items() <= own.items()]

    def value(self, suffix="", **labels):
        found = self.values(suffix, **labels)
        return sum(found) if found else 0

    def labels(self, name):
        return {own[name] for _, own, _ in self.samples if name in own}


def parse(text):
    """Families by name."""
    if text and not text.endswith("\n"):
        raise ValueError("the last line does not end")
    families, current, seen = {}, None, set()
    for line in text.splitlines():
        try:
            current = take_line(line, families, current, seen)
        except ValueError as error:
            raise ValueError(f"{error}: {line}") from None
    for family in families.values():
        check(family)
    return families


def take_line(line, families, current, seen):
    if line.startswith(("# HELP ", "# TYPE ")):
        return take_comment(line, families, current)
    match = SAMPLE.match(line)
    if not match:
        raise ValueError("no sample")
    name, labels, value = match.group(1), parse_labels(match.group(2)), float(match.group(3))
    if not current or not belongs(name, current):
        raise ValueError("a sample outside of its family")
    key = (name, tuple(sorted(labels.items())))
    if key in seen:
        raise ValueError("a series twice")
    seen.add(key)
    current.samples.append((name, labels, value))
    return current


def take_comment(line, families, current):
    what, name, rest = line[2:].split(" ", 2)
    if not NAME.match(name):
        raise ValueError("a bad name")
    if not current or current.name != name:
        if name in families:
            raise ValueError("a family in two places")
        current = families[name] = Family(name)
    if current.samples:
        raise ValueError("a comment after samples")
    key = "help" if what == "HELP" else "kind"
    if getattr(current, key) is not None:
        raise ValueError("a comment twice")
    if what == "TYPE" and rest not in KINDS:
        raise ValueError("an unknown type")
    setattr(current, key, rest)
    return current


def belongs(name, family):
    if family.kind == "histogram":
        return name in [family.name + end for end in ("_bucket", "_sum", "_count")]
    return name == family.name


def parse_labels(text):
    if not text:
        return {}
    inside, labels, at = text[1:-1], {}, 0
    while at < len(inside):
        match = PAIR.match(inside, at)
        if not match:
            raise ValueError("bad labels")
        if match.group(1) in labels or match.group(1).startswith("__"):
            raise ValueError("a label twice or reserved")
        labels[match.group(1)] = re.sub(
            r"\\(.)", lambda m: "\n" if m.group(1) == "n" else m.group(1), match.group(2))
        at = match.end()
    if inside.endswith(","):
        raise ValueError("a comma too many")
    return labels


def check(family):
    """What promtool says of a whole family."""
    if not family.kind or not family.help:
        raise ValueError(f"{family.name}: no HELP or no TYPE")
    if (family.kind == "counter") != family.name.endswith("_total"):
        raise ValueError(f"{family.name}: only counters end in _total, and all do")
    if family.kind == "counter" and any(not value >= 0 for _, _, value in family.samples):
        raise ValueError(f"{family.name}: a counter below zero")
    if family.kind == "histogram":
        check_histogram(family)
    names = {frozenset(labels) - {"le"} for _, labels, _ in family.samples}
    if len(names) > 1:
        raise ValueError(f"{family.name}: series with different labels")


def check_histogram(family):
    groups = {}
    for name, labels, value in family.samples:
        key = tuple(sorted((k, v) for k, v in labels.items() if k != "le"))
        group = groups.setdefault(key, {"buckets": []})
        if name.endswith("_bucket"):
            group["buckets"].append((float(labels["le"].replace("+Inf", "inf")), value))
        else:
            group[name.rsplit("_", 1)[1]] = value
    for group in groups.values():
        ends, counts = zip(*group["buckets"])
        if list(ends) != sorted(set(ends)) or ends[-1] != math.inf:
            raise ValueError(f"{family.name}: buckets out of order or without +Inf")
        if list(counts) != sorted(counts) or counts[-1] != group["count"] or "sum" not in group:
            raise ValueError(f"{family.name}: buckets that are not cumulative")
