"""Sweeps: many plans from one command line, each built into its own folder.

- command: Runs or plans a sweep from the command line.
- fetching: Fetches the sources of a sweep once, before its first job.
- folder: Writes the folder of a sweep: its own files beside the folders of its jobs.
- job_launcher: Runs jobs of a sweep, whose sources are fetched, under its launcher.
- job_list: Reads and writes job lists: files with the jobs of a sweep, for any scheduler to run.
- launch: Runs a sweep under one of Hydra's launchers.
- list_commands: Runs the verbs about a list of jobs: `linkwright jobs` and `linkwright job`.
- listed_jobs: Writes the jobs of a sweep as a list; composes, fetches and runs them again; reads their
  outcomes.
- outcome: Describes how a job of a sweep ended: its state, message, figures and checks.
- outcome_files: Keeps the outcome of each job in a file, and reads the outcomes of all jobs from the sweep's
  folder.
- run: Composes the jobs of a sweep, each with a plan, a label and a folder, and runs a single job.
- search: Runs a sweep whose jobs a searching sweeper of Hydra chooses, by the objectives of earlier jobs.
- summary_csv: Makes the content of summary.csv, with a row for each job.
- summary_json: Reads and writes summary.json, with the runs of a sweep.
- summary_updates: Keeps the summary of a sweep up to date while its jobs run.
- terminal_table: Lays out the closing table in the terminal.
"""
