"""Holds the texts of `--help`, a screen, and `--help-all`, within 80 columns. Imports nothing heavy."""

SHORT = """\
linkwright: a robot is a YAML file; this builds it.

usage: linkwright [option ...] [group=option ...] [key=value ...]

  linkwright                          build the sample that is shipped, offline
  linkwright new "https://cad.onshape.com/documents/..." my_arm
                                      write ./robot/my_arm.yaml from an assembly
  linkwright robot=my_arm             build ./robot/my_arm.yaml
  linkwright source=urdf source.path=arm.urdf         a URDF; source=mjcf: MJCF
  linkwright robot=my_arm until=graph                 stop early: show its tree
  linkwright robot=my_arm root=free joints.elbow.damping=0.2     change options
  linkwright -m robot=my_arm root=fixed,free          a sweep, a folder for each

options: -q only errors, -v all findings, --json for programs; -m sweeps a,b,c;
         --config-dir DIR holds robot/; --cfg job prints the configuration
groups:  robot source root depth mesh ground export target validate actuators
         elements
verbs:   new bundle view check diff snapshot cache explain doctor skill jobs job
         (linkwright VERB --help)

  linkwright explain KEY|CODE         what a key or the code of a message means
  linkwright --help-all               all options, groups, keys and variables
  linkwright --install-completion     the tab key completes all of them
"""

_WHOLE = """\
linkwright: a robot is a YAML file; this builds it.

usage: linkwright [option ...] [group=option ...] [key=value ...]

  linkwright                      build the sample that is shipped (no network)
  linkwright robot=my_arm         build ./robot/my_arm.yaml
  linkwright source=onshape "source.url='https://cad.onshape.com/documents/...'"
                                  build an assembly; both pairs of quotes are
                                  needed
  linkwright source=urdf source.path=arm.urdf
                                  build from a URDF or a xacro file, and its
                                  meshes
  linkwright source=mjcf source.path=arm.xml
                                  build from an MJCF (MuJoCo XML)
  linkwright robot=my_arm until=graph
                                  stop after a stage: fetch graph mesh export
                                  validate
  linkwright robot=my_arm "joints.*.damping=0.2" root=free
                                  change keys and options of a robot
  linkwright experiment=wide      build the robot of ./experiment/wide.yaml with
                                  its changes
  linkwright -m robot=my_arm root=fixed,free
                                  a sweep: every combination, a folder each

other verbs (linkwright VERB --help shows more):
  linkwright new URL|FILE [NAME]  write ./robot/NAME.yaml from an assembly or a
                                  file, with what is found and what is missing
  linkwright bundle NAME out.zip  pack the inputs of the build of NAME, to build
                                  it anywhere
  linkwright view NAME            open the robot of a build in MuJoCo's viewer
  linkwright check DIR|FILE       whether the files of a robot are right, as
                                  they are now
  linkwright diff A B             what is different between two robots
  linkwright snapshot [DIR]       keep what the robots of a repository come to,
                                  as texts; --check compares
  linkwright cache info|gc|verify
                                  show the cache's size and API calls, clean it,
                                  check it
  linkwright doctor               whether builds can work on this computer, and
                                  what to do where not
  linkwright explain CODE|KEY     explain a diagnostic's code, a key, or the
                                  exit status (explain exit)
  linkwright skill                print the instructions for agents
  linkwright jobs FILE            which jobs of a list are done; --fetch fetches
                                  their sources
  linkwright job FILE N           run job N of a list, anywhere

options:
  -v, --verbose          all findings, whole; else the worst three of each code
  -q, --quiet            only errors and failed checks
  --json                 print one JSON document and nothing else; verbs have
                         this option, too (linkwright explain --schema build)
  -m, --multirun         sweep over values that are separated by commas;
                         in parallel with hydra/launcher=workstation, slurm,
                         slurm_local or ray
  --plan FILE            with -m: write the list of its jobs and build nothing;
                         --offline makes no call for it
  --config-dir DIR       DIR holds robot/ with robots of your own (besides
                         ./robot/); may be repeated
  --cfg job|hydra|all    print the validated configuration and build nothing;
                         --resolve replaces ${...} by values, --package KEY
                         prints a part
  --info [KIND]          print how the configuration is composed: all config
                         defaults defaults-tree plugins searchpath
  --install-completion [SHELL]
                         install tab completion for bash, zsh or fish (in this
                         shell only: -sc install=SHELL)
  -h, --help             the most important of this text
  --help-all             this text
  --version              the version

groups, each a set of presets (group=option):
  robot       sample, quadruped, delta, rover, hand, legged, bare, and the
              files in ./robot/: everything below, in one file
  source      onshape, urdf, mjcf, bundle (a zip of replies), sample
  root        auto, central, fixed, free: the root link and its base
  depth       flexible, rigid: which sub-assemblies may move inside
  mesh        ladder, hull, coacd, primitives, spheres, raw, visual (none): the
              colliders
  ground      plane, none
  export      [urdf,mjcf], urdf, mjcf, sdf, usd, ros2, python: the formats;
              [urdf,mjcf,sdf] several
  target      none, mjx, mjwarp, mujoco, newton, isaac, gazebo, pybullet, drake:
              the engines whose limits the files keep; [mjx,newton] several
  validate    quick, standard, strict (warnings are errors)
  actuators   none, motor, position, velocity, intvelocity, pid (servos),
              legged, damper, general: what drives joints
  elements    none

keys (key=value; linkwright explain KEY shows type, unit, default, an example):
{keys}

environment:
{environment}

{exit}
"""


def whole() -> str:
    """Returns the text of `--help-all`; its list of keys is generated from the schema."""
    # Imported late: `--help` does not need the reference.
    from linkwright.pipeline.reference import HELP, environment, exit_status

    keys = HELP.read_text(encoding="utf-8").rstrip()
    text = _WHOLE.replace("{keys}", keys).replace("{environment}", environment.text())
    return text.replace("{exit}", exit_status.paragraph("build"))
