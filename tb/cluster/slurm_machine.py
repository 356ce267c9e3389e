"""Slurm with several nodes on this machine, without systemd and as any user; nothing of it is left at the end."""

import getpass
import os
import pathlib
import secrets
import shutil
import signal
import socket
import subprocess
import time

SECONDS_TO_START = 30
# Debian keeps daemons outside of a user's PATH.
DAEMON_PATH = "/usr/sbin:/sbin"

CONFIGURATION = """\
ClusterName=metabuffer
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={controller_port}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={folder}/munge/socket
CredType=cred/munge
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool-%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd-%n.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd-%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerType=sched/builtin
SchedulerParameters=batch_sched_delay=0,sched_interval=1,sched_min_interval=0
SwitchType=switch/none
MpiDefault=none
ReturnToService=2
SlurmdTimeout={node_timeout}
KillWait=10
MailProg=/bin/true
{nodes}
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


def free_ports(count):
    sockets = [socket.socket() for _ in range(count)]
    try:
        for each in sockets:
            each.bind(("127.0.0.1", 0))
        return [each.getsockname()[1] for each in sockets]
    finally:
        for each in sockets:
            each.close()


class SlurmMachine:
    """with SlurmMachine(folder, nodes=2) as slurm: subprocess.run(..., env=slurm.environment)"""

    def __init__(self, folder, nodes=2, node_timeout_seconds=10):
        self.folder = pathlib.Path(folder)
        self.nodes = [f"n{n + 1}" for n in range(nodes)]
        self.processes = {}
        self.environment = dict(os.environ, SLURM_CONF=str(self.folder / "slurm.conf"),
                                PATH=os.environ["PATH"] + ":" + DAEMON_PATH)
        # A job of these tests may itself run in one of Slurm's.
        for name in list(self.environment):
            if name.startswith(("SLURM_", "SBATCH_", "SQUEUE_")) and name != "SLURM_CONF":
                del self.environment[name]
        self.node_timeout_seconds = node_timeout_seconds

    def __enter__(self):
        try:
            self._start()
        except BaseException:
            self.stop()
            raise
        return self

    def __exit__(self, *_):
        self.stop()

    def _start(self):
        for program in ("munged", "slurmctld", "slurmd", "sbatch"):
            if shutil.which(program, path=self.environment["PATH"]) is None:
                raise RuntimeError(f"{program} is not installed (packages slurm-wlm and munge)")
        for name in ("munge", "state"):
            (self.folder / name).mkdir(mode=0o700)
        # The folders above must belong to nobody else, or munge does not start.
        self.folder.chmod(0o700)
        key = self.folder / "munge/key"
        key.touch(mode=0o600)
        key.write_bytes(secrets.token_bytes(1024))
        ports = free_ports(1 + len(self.nodes))
        host = socket.gethostname().split(".")[0]
        nodes = "\n".join(f"NodeName={node} NodeHostname={host} NodeAddr=127.0.0.1 Port={port} CPUs=1"
                          for node, port in zip(self.nodes, ports[1:]))
        (self.folder / "slurm.conf").write_text(
            CONFIGURATION.format(host=host, controller_port=ports[0], user=getpass.getuser(), folder=self.folder,
                                 node_timeout=self.node_timeout_seconds, nodes=nodes), encoding="utf-8")
        munge = self.folder / "munge"
        self._spawn("munged", "munged", "--foreground", "--force", f"--key-file={munge}/key",
                    f"--socket={munge}/socket", f"--pid-file={munge}/pid", f"--log-file={munge}/log",
                    f"--seed-file={munge}/seed")
        self._wait_until(lambda: (munge / "socket").exists(), "munged")
        self._spawn("slurmctld", "slurmctld", "-D", "-c")
        for node in self.nodes:
            self.start_node(node)
        self._wait_until(lambda: self.run("sinfo", "--noheader", "--format=%t").split() == ["idle"], "slurmctld")

    def start_node(self, node):
        self._spawn(node, "slurmd", "-D", "-N", node)

    def _spawn(self, name, *command):
        with open(self.folder / f"{name}.out", "wb") as output:
            self.processes[name] = subprocess.Popen(command, env=self.environment, stdin=subprocess.DEVNULL,
                                                    stdout=output, stderr=output)

    def _wait_until(self, condition, what):
        deadline = time.monotonic() + SECONDS_TO_START
        while time.monotonic() < deadline:
            for name, process in self.processes.items():
                if process.poll() is not None:
                    raise RuntimeError(f"{name} has ended: {(self.folder / (name + '.out')).read_text()}")
            if condition():
                return
            time.sleep(0.1)
        raise RuntimeError(f"{what} is not there after {SECONDS_TO_START} s: see {self.folder}")

    def run(self, *command):
        """Runs a command of Slurm; returns what it prints, or nothing if it fails."""
        return subprocess.run(command, env=self.environment, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                              text=True, check=False).stdout

    def kill_node(self, node):
        """Kills its slurmd only, as a crash would: the node's job lives on."""
        process = self.processes.pop(node)
        process.send_signal(signal.SIGKILL)
        process.wait()

    def stop(self):
        self.run("scancel", "--me", "--signal=KILL")
        # Jobs first, since they outlive a node that is gone.
        for pid in self._processes_of_jobs():
            try:
                os.kill(pid, signal.SIGKILL)
            except ProcessLookupError:
                pass
        for process in reversed(list(self.processes.values())):
            process.terminate()
        for process in self.processes.values():
            try:
                process.wait(timeout=10)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        self.processes.clear()
        for pid in self._processes_of_jobs():
            try:
                os.kill(pid, signal.SIGKILL)
            except ProcessLookupError:
                pass

    def _processes_of_jobs(self):
        """The processes that have this Slurm in their environment, except for this one and the daemons."""
        mark = f"SLURM_CONF={self.folder}/slurm.conf".encode()
        own = {os.getpid()} | {process.pid for process in self.processes.values()}
        pids = []
        for entry in pathlib.Path("/proc").iterdir():
            if not entry.name.isdigit() or int(entry.name) in own:
                continue
            try:
                if mark in (entry / "environ").read_bytes().split(b"\0"):
                    pids.append(int(entry.name))
            except OSError:
                pass
        return pids

    def leftovers(self):
        return self._processes_of_jobs()
