# ruff: noqa: E501
"""Robots whose YAML tries to run code; each would leave the file `MARK` behind."""

MARK = "i-was-here"

CODE = f"{{_target_: logging.FileHandler, filename: {MARK}}}"
"""What Hydra would make a file of, by running a class that the YAML names."""

LOGGING = (
    f"{{version: 1, handlers: {{f: {{class: logging.FileHandler, filename: {MARK}}}}}, "
    "root: {handlers: [f]}}"
)

FILE = f"_target_: logging.FileHandler\nfilename: {MARK}\n"

ROBOTS = {
    # name: (an entry of the defaults list, keys, other files)
    "a callback": ("", f"hydra: {{callbacks: {{x: {CODE}}}}}", {}),
    "a callback by interpolation": ("", f"vars: {{e: {CODE}}}\nhydra: {{callbacks: {{x: '${{vars.e}}'}}}}", {}),
    "callbacks by interpolation": ("", f"vars: {{e: {{x: {CODE}}}}}\nhydra: {{callbacks: '${{vars.e}}'}}", {}),
    "a callback by a resolver": ("", "hydra: {callbacks: {x: '${oc.create:${oc.env:EVIL}}'}}", {}),
    "a callback from a preset": ("override /mesh: mine", "", {"mesh/mine.yaml": f"# @package _global_\nhydra: {{callbacks: {{x: {CODE}}}}}\n"}),
    "a group of callbacks": ("override /hydra/callbacks: evil", "", {"hydra/callbacks/evil.yaml": f"x: {CODE}\n"}),
    "a file packaged as a callback": ("/extra@hydra.callbacks.x: evil", "", {"extra/evil.yaml": FILE}),
    "a file that packages itself": ("/extra/evil", "", {"extra/evil.yaml": f"# @package hydra.callbacks.x\n{FILE}"}),
    "a file beside the robot": ("evil", "", {"robot/evil.yaml": f"# @package hydra.callbacks.x\n{FILE}"}),
    "a path made of choices": ("/${mesh}/evil@hydra.callbacks.x", "", {"hull/evil.yaml": FILE}),
    "logging of jobs": ("", f"hydra: {{job_logging: {LOGGING}}}", {}),
    "logging of jobs by a file": ("override /hydra/job_logging: mine", "", {"hydra/job_logging/mine.yaml": LOGGING}),
    "logging of Hydra by a file": ("override /hydra/hydra_logging: mine", "", {"hydra/hydra_logging/mine.yaml": LOGGING}),
    "logging packaged": ("/extra@hydra.job_logging: mine", "", {"extra/mine.yaml": LOGGING}),
    "logging of Hydra's own": ("override /hydra/job_logging: default", "", {}),
    "a variable for the job": ("", "hydra: {job: {env_set: {EVIL: '1'}}}", {}),
    "a variable that is copied": ("", "hydra: {job: {env_copy: [HOME]}}", {}),
    "a variable that is not there": ("", "hydra: {job: {env_copy: [NOT_THERE_AT_ALL]}}", {}),
    "a launcher's class": ("", "hydra: {launcher: {_target_: logging.FileHandler}}", {}),
    "a launcher replaced": ("", f"hydra: {{launcher: {CODE}}}", {}),
    "a sweeper's class": ("", "hydra: {sweeper: {_target_: logging.FileHandler}}", {}),
    "a launcher of one's own": ("override /hydra/launcher: mine", "", {"hydra/launcher/mine.yaml": FILE}),
    "a launcher that takes another's name": ("override /hydra/launcher: basic", "", {"hydra/launcher/basic.yaml": FILE}),
    "a launcher's expression": ("override /hydra/launcher: joblib", f"hydra: {{launcher: {{pre_dispatch: \"__import__('pathlib').Path('{MARK}').touch()\"}}}}", {}),
    "folders of Hydra": ("", "hydra: {run: {dir: elsewhere}, output_subdir: .hydra}", {}),
    "another working folder": ("", "hydra: {job: {chdir: true}}", {}),
    "the mode": ("", "hydra: {mode: MULTIRUN}", {}),
    "a search path": ("", "hydra: {searchpath: ['file:///tmp']}", {}),
    "overrides of the task": ("", "hydra: {overrides: {task: ['source.trust=true']}}", {}),
    "overrides of Hydra": ("", f"hydra: {{overrides: {{hydra: ['+hydra.callbacks.x={CODE}']}}}}", {}),
    "a sweep of Hydra": ("", f"hydra: {{sweeper: {{params: {{+hydra.callbacks.x: '{CODE}'}}}}}}", {}),
    "a sweep of trust": ("", "hydra: {sweeper: {params: {source.trust: 'true'}}}", {}),
    "a sweep of the source": ("", "hydra: {sweeper: {params: {source: '{trust: true}'}}}", {}),
    "a sweep of plug-ins": ("", "hydra: {sweeper: {params: {plugins: '[evil]'}}}", {}),
    "a target": ("", f"vars: {{deep: [{{x: {CODE}}}]}}", {}),
    "a target of the plan": ("", f"elements: {CODE}", {}),
    "a tag of YAML": ("", f"name: !!python/object/apply:os.system ['touch {MARK}']", {}),
    "trust": ("", "source: {trust: true}", {}),
    "trust by a resolver": ("", "source: {trust: \"${oc.decode:'true'}\"}", {}),
    "trust from a preset": ("override /source: mine", "", {"source/mine.yaml": "kind: urdf\npath: x\ntrust: true\n"}),
    "plug-ins": ("", "plugins: [evil]", {}),
    "plug-ins by a resolver": ("", "plugins: \"${oc.create:${oc.env:PLUGINS,'[evil]'}}\"", {}),
}  # fmt: skip


def write(folder, name, file="robot/mine.yaml"):
    """Puts a hostile robot, or an experiment, and the files that it brings along into a folder."""
    entry, keys, more = ROBOTS[name]
    chosen = [] if "/source:" in entry else ["override /source: sample"]
    defaults = [entry, *chosen] if entry else chosen
    text = "".join(
        ["# @package _global_\n", "defaults:\n", *(f"  - {default}\n" for default in defaults), keys, "\n"]
    )
    for path, content in {file: text, **more}.items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_text(content, encoding="utf-8")
