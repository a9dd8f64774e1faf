"""Clusters and farms make the same crowd as one process."""

import os
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.digests import digests
from usdfoot.batch.executors import open_executor
from usdfoot.batch.job import job_template
from usdfoot.cli.main import main
from usdfoot.errors import OutputError, SceneError, UsdfootError
from usdfoot.pipeline.animate import animate, animate_chunk
from usdfoot.writers.folder_lock import lock_folder


@contextmanager
def cluster(folder):
    """Address of a Dask scheduler, and its two workers, each a process of its own."""
    contact = folder / "scheduler.json"
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    options = ["--no-dashboard", "--scheduler-file", str(contact)]
    dask = [sys.executable, "-m", "dask"]
    scheduler = [*dask, "scheduler", "--host", "127.0.0.1", "--port", "0", *options]
    worker = [*dask, "worker", "--nthreads", "1", "--no-nanny", "--local-directory", str(folder), *options]
    processes = [subprocess.Popen(scheduler, **quiet)]
    try:
        deadline = time.monotonic() + 60.0
        while not contact.exists() and time.monotonic() < deadline:
            time.sleep(0.05)
        processes += [subprocess.Popen(worker, **quiet) for _ in range(2)]
        from distributed import Client

        with Client(scheduler_file=str(contact), timeout=60.0, set_as_default=False) as client:
            client.wait_for_workers(2, timeout=60.0)
            yield client.scheduler.address, processes[1:]
    finally:
        for process in reversed(processes):
            process.terminate()
            process.wait(30.0)


def test_a_dask_cluster_makes_the_same_bytes_also_when_a_worker_is_killed(crowd, crowd_scene, tmp_path):
    pytest.importorskip("distributed", reason="the extra dask is not installed")
    with cluster(tmp_path) as (address, workers):
        arguments = ["animate", str(crowd_scene), "-o", str(tmp_path / "out"), "--chunk-size", "1", "-q"]
        assert main([*arguments, "--scheduler", address]) == 0
        assert digests(tmp_path / "out") == digests(crowd.crowd_file.parent)

        def kill_one(part, done, total):
            if (part, done) == ("animate", 1):
                workers[0].kill()

        with open_executor(scheduler=address) as executor:
            animate(crowd_scene, tmp_path / "killed", chunk_size=1, executor=executor, progress=kill_one)
        assert workers[0].wait(10.0) and digests(tmp_path / "killed") == digests(tmp_path / "out")


def test_a_cluster_without_workers_is_given_up_and_the_next_run_goes_on(crowd, crowd_scene, tmp_path, monkeypatch):
    pytest.importorskip("distributed", reason="the extra dask is not installed")
    monkeypatch.setattr("usdfoot.batch.executors.WITHOUT_WORKERS", 0.5)
    monkeypatch.setattr("usdfoot.batch.executors.ABANDONED", 3.0)

    def kill_all(part, done, total):
        if (part, done) == ("animate", 1):
            [worker.kill() for worker in workers]

    with cluster(tmp_path) as (address, workers):
        lost = pytest.raises(OutputError, match=r"chunks were not made: .*has had no workers for 3 s.*run again")
        with lost, open_executor(scheduler=address) as executor:
            animate(crowd_scene, tmp_path / "out", chunk_size=1, executor=executor, progress=kill_all)
    again = animate(crowd_scene, tmp_path / "out", chunk_size=1)
    assert again.kept and digests(tmp_path / "out") == digests(crowd.crowd_file.parent)


def test_a_scheduler_that_does_not_answer_is_named(crowd_scene, tmp_path, capsys, monkeypatch):
    pytest.importorskip("distributed", reason="the extra dask is not installed")
    monkeypatch.setattr("usdfoot.batch.executors.SCHEDULER_TIMEOUT", 0.5)
    arguments = ["animate", str(crowd_scene), "-o", str(tmp_path / "out"), "-q", "--scheduler", "tcp://127.0.0.1:9"]
    assert main(arguments) == 2
    assert "tcp://127.0.0.1:9: no Dask scheduler answers" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_farm_runs_the_job_and_makes_the_same_bytes(pairs, crowd_scene, tmp_path, capsys):
    pytest.importorskip("openjd.cli", reason="openjd-cli is not installed")
    scripts = Path(sys.executable).parent
    folder = tmp_path / "out"
    assert main(["job", str(crowd_scene), "-o", str(folder), "-q", "--with=--chunk-size 2"]) == 0
    job = tmp_path / "job.yaml"
    job.write_text(capsys.readouterr().out)
    environment = {**os.environ, "PATH": f"{scripts}{os.pathsep}{os.environ['PATH']}"}
    openjd = [sys.executable, "-m", "openjd"]
    subprocess.run([*openjd, "check", str(job)], check=True, capture_output=True, env=environment)
    run = [*openjd, "run", str(job), "--step", "Crowd", "--run-dependencies"]
    done = subprocess.run(run, capture_output=True, text=True, env=environment, cwd=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    assert f"kept {pairs.chunks} of {pairs.chunks} chunks" in done.stdout
    assert digests(folder) == digests(pairs.crowd_file.parent)


def test_a_job_names_what_it_is_given():
    job = job_template("/shots/a b.usda", "/out", chunks=3, options=["--root-weight", "0.5"])
    assert 'default: "/shots/a b.usda"' in job and 'range: "0-2"' in job
    assert '"--root-weight", "0.5", "--chunk", "{{Task.Param.Chunk}}"' in job


@pytest.mark.parametrize("name", ["{{Task.X}}.usda", 200 * "x" + ".usda", "a\nb.usda", "ü 日本.usda"])
def test_a_job_of_any_scene_is_a_template(name, tmp_path):
    pytest.importorskip("openjd.cli", reason="openjd-cli is not installed")
    (tmp_path / "job.yaml").write_text(job_template(f"/shots/{name}", "/out", chunks=2), encoding="utf-8")
    check = [sys.executable, "-m", "openjd", "check", str(tmp_path / "job.yaml")]
    assert subprocess.run(check, capture_output=True).returncode == 0


def test_options_that_a_job_cannot_pass_on_are_refused(crowd_scene, tmp_path, capsys):
    with pytest.raises(UsdfootError, match=r"options: have \{\{ in them.*: \{\{Param.Scene\}\}"):
        job_template("/shots/a.usda", "/out", chunks=2, options=["--agents", "{{Param.Scene}}"])
    for options in ("--chunk 0", "--scheduler tcp://head:8786", f"-o {tmp_path}/elsewhere"):
        flag = options.split()[0]
        assert main(["job", str(crowd_scene), "-o", str(tmp_path / "out"), f"--with={options}"]) == 2
        assert f"--with: says what the job itself says: {flag}. leave it out" in capsys.readouterr().err


def test_a_chunk_that_is_not_there_is_named(crowd_scene, tmp_path):
    with pytest.raises(SceneError, match=r"has no chunk 3\. give one of 0 to 2"):
        animate_chunk(crowd_scene, tmp_path, 3, chunk_size=1)
    with pytest.raises(OutputError, match="another run is writing into it"), lock_folder(tmp_path):
        animate_chunk(crowd_scene, tmp_path, 0, chunk_size=1)
