#!/usr/bin/env python3
"""Makes scatterd.json, the Grafana dashboard, out of the table of panels below.

    python3 make.py > scatterd.json

In Grafana: Dashboards, New, Import; then choose the Prometheus that scrapes /metrics.
"""

import json
import sys

ROUTE = '{route=~"$route"}'

# title, unit, [(expression, legend)], width of 24; a new row begins where the width is used up
PANELS = [
    ("Ready", "short", [("min(scatterd_ready)", "ready")], 4),
    ("Version", "short", [("scatterd_build_info", "{{version}}")], 4),
    ("Queue", "short", [("scatterd_queue_length", "waiting"), ("scatterd_queue_limit", "limit")], 8),
    ("Workers", "short", [("scatterd_workers", "{{state}}")], 8),
    ("Requests", "reqps",
     [(f"sum by (route, status) (rate(scatterd_http_requests_total{ROUTE}[$__rate_interval]))",
       "{{route}} {{status}}")], 12),
    ("Failures", "reqps",
     [('sum by (status) (rate(scatterd_http_requests_total{status=~"5..|429|aborted"}'
       "[$__rate_interval]))", "{{status}}")], 12),
    ("Latency of requests", "s",
     [(f"histogram_quantile({q}, sum by (le, route) (rate(scatterd_http_request_seconds_bucket{ROUTE}"
       "[$__rate_interval])))", f"{{{{route}}}} {name}")
      for q, name in ((0.5, "median"), (0.99, "99 %"))], 12),
    ("Time on a worker", "s",
     [("histogram_quantile(0.5, sum by (le, process, work) (rate(scatterd_run_seconds_bucket"
       "[$__rate_interval])))", "{{process}} {{work}} median"),
      ("histogram_quantile(0.99, sum by (le) (rate(scatterd_queue_wait_seconds_bucket"
       "[$__rate_interval])))", "wait for a worker, 99 %")], 12),
    ("Phases: workers busy with each", "short",
     [("sum by (phase) (rate(scatterd_phase_seconds_total[$__rate_interval]))", "{{phase}}")], 12),
    ("Runs by their end", "ops",
     [("sum by (process, work, end) (rate(scatterd_runs_total[$__rate_interval]))",
       "{{process}} {{work}} {{end}}"),
      ("sum by (process) (rate(scatterd_runs_cancelled_total[$__rate_interval]))",
       "{{process}} cancelled")], 12),
    ("Memory", "bytes",
     [("scatterd_workers_resident_memory_bytes", "workers"),
      ("process_resident_memory_bytes", "front"),
      ("scatterd_worker_memory_limit_bytes", "limit of a worker")], 8),
    ("Workers started and ended", "ops",
     [("rate(scatterd_worker_starts_total[$__rate_interval])", "started"),
      ("sum by (how) (rate(scatterd_worker_exits_total[$__rate_interval]))", "ended: {{how}}")], 8),
    ("Bodies", "Bps",
     [("sum(rate(scatterd_http_request_bytes_total[$__rate_interval]))", "in"),
      ("sum(rate(scatterd_http_response_bytes_total[$__rate_interval]))", "out")], 8),
    ("Jobs", "short", [("scatterd_jobs", "{{state}}"), ("scatterd_jobs_room", "room")], 8),
    ("Jobs ended", "ops",
     [("sum by (state) (rate(scatterd_jobs_ended_total[$__rate_interval]))", "{{state}}")], 8),
    ("Memory of running jobs, estimated", "bytes",
     [("scatterd_jobs_memory_bytes", "running"),
      ("scatterd_jobs_memory_limit_bytes", "most for one")], 8),
    ("Store", "bytes",
     [("scatterd_store_free_bytes", "free"), ("scatterd_store_bytes", "database")], 8),
    ("Descriptors of the front", "short",
     [("process_open_fds", "open"), ("process_max_fds", "limit")], 8),
    ("Processor of the front", "percentunit",
     [("rate(process_cpu_seconds_total[$__rate_interval])", "front")], 8),
]

SOURCE = {"type": "prometheus", "uid": "${source}"}


def panels():
    """The panels, laid out in rows."""
    x = y = 0
    height = 8
    for number, (title, unit, targets, width) in enumerate(PANELS, 1):
        if x + width > 24:
            x, y = 0, y + height
        yield {
            "id": number, "title": title, "type": "stat" if width == 4 else "timeseries",
            "datasource": SOURCE, "gridPos": {"x": x, "y": y, "w": width, "h": height},
            "fieldConfig": {"defaults": {"unit": unit, "min": 0}, "overrides": []},
            "options": {"textMode": "name"} if title == "Version" else {},
            "targets": [{"refId": chr(65 + k), "expr": expression, "legendFormat": legend,
                         "datasource": SOURCE} for k, (expression, legend) in enumerate(targets)],
        }
        x += width


def dashboard():
    return {
        "title": "scatterd", "uid": "scatterd", "schemaVersion": 38, "editable": True,
        "tags": ["scatterd"], "refresh": "10s", "time": {"from": "now-1h", "to": "now"},
        "templating": {"list": [
            {"name": "source", "type": "datasource", "query": "prometheus", "label": "Prometheus"},
            {"name": "route", "type": "query", "label": "Route", "datasource": SOURCE,
             "query": "label_values(scatterd_http_requests_total, route)", "includeAll": True,
             "multi": True, "allValue": ".*", "current": {"text": "All", "value": "$__all"}},
        ]},
        "panels": list(panels()),
    }


if __name__ == "__main__":
    json.dump(dashboard(), sys.stdout, indent=1)
    sys.stdout.write("\n")
