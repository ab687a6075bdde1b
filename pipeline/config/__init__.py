"""From a command line and YAML files to a plan. The only place that knows Hydra."""
