"""The command line: options, configuration file, help, scatterd run."""

import os
import subprocess
import tempfile
import unittest

import daemon


def run(*words, **how):
    return subprocess.run([daemon.program(stub=True), *words], capture_output=True, text=True,
                          timeout=daemon.PATIENCE, check=False, **how)


class Words(unittest.TestCase):

    def test_help(self):
        for word in ("--help", "-h"):
            done = run(word)
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            for text in ("--listen", "--memory-bytes", "scatterd run", "127.0.0.1:8480"):
                self.assertIn(text, done.stdout)

    def test_version(self):
        self.assertRegex(run("--version").stdout, r"^scatterd \d+\.\d+\.\d+\n$")

    def test_reference_names_every_option_of_help(self):
        page = run("--print-parameters").stdout
        options = [line.split()[0][2:] for line in run("--help").stdout.splitlines()
                   if line.startswith("  --") and "|" not in line.split()[1]]
        self.assertGreater(len(options), 20)
        for option in options:
            self.assertIn(f"| {option} |", page)

    def test_mistakes(self):
        for words, expected in [(["--nothing", "1"], "nothing"),
                                (["--workers", "many"], "many"),
                                (["--workers=-1"], "0 to 1024"),
                                (["--threads"], "no value"),
                                (["--body-bytes", "1XiB"], "1XiB"),
                                (["--public-url", "ftp://x"], "http://"),
                                (["--log-level", "loud"], "error, info or debug"),
                                (["serve"], "serve"),
                                (["--config", "/does/not/exist"], "/does/not/exist"),
                                (["worker"], "worker")]:
            with self.subTest(words):
                done = run(*words)
                self.assertEqual(done.returncode, 2)
                self.assertIn(expected, done.stderr)

    def test_what_cannot_be_done(self):
        for words, expected in [(["--listen", "nonsense"], "ADDR:PORT"),
                                (["--listen", "192.0.2.1:0"], "192.0.2.1:0"),
                                (["--listen", "unix:/does/not/exist/s"], "/does/not/exist/s"),
                                (["--listen", "unix:" + 200 * "x"], "200 characters"),
                                (["--listen", "127.0.0.1:0", "--data-dir", "/proc/x"], "/proc/x")]:
            with self.subTest(words):
                done = run("--data-dir", tempfile.gettempdir(), *words)
                self.assertEqual(done.returncode, 1)
                self.assertIn(expected, done.stderr)


class Configuration(unittest.TestCase):

    def write(self, text):
        with tempfile.NamedTemporaryFile("w", suffix=".conf", delete=False) as file:
            file.write(text)
        self.addCleanup(os.unlink, file.name)
        return file.name

    def test_file_and_command_line(self):
        path = self.write("# a comment\n\n  workers = 3  # another\nbody-bytes=1 KiB\n"
                          "seconds = 0.5\n")
        d = daemon.Daemon("--seconds", "60", "--config", path)
        self.addCleanup(d.stop)
        d.wait_ready()
        d.wait_for_log("workers=3")
        self.assertEqual(d.request("POST", daemon.EXECUTE, b"x" * 1025).status, 413)
        self.assertEqual(d.request("POST", daemon.EXECUTE, b"x" * 1024).status, 200)
        self.assertEqual(d.request("POST", daemon.EXECUTE, b"sleep 1").status, 200)

    def test_mistakes_name_file_and_line(self):
        for text, line, expected in [("workers = 1\nworkers = x\n", 2, '"x"'),
                                     ("\nnothing = 1\n", 2, "nothing"), ("workers\n", 1, "=")]:
            path = self.write(text)
            done = run("--config", path)
            self.assertEqual(done.returncode, 2)
            self.assertIn(f"{path}:{line}:", done.stderr)
            self.assertIn(expected, done.stderr)

    def test_data_directory_of_the_user(self):
        with tempfile.TemporaryDirectory() as home:
            d = daemon.Daemon("--data-dir", "", environment={
                "HOME": home, "XDG_DATA_HOME": ""})
            self.assertTrue(os.path.isdir(home + "/.local/share/scatterd"))
            self.assertEqual(d.stop(), 0)
            d = daemon.Daemon("--data-dir", "", environment={
                "HOME": home, "XDG_DATA_HOME": home + "/data"})
            self.assertTrue(os.path.isdir(home + "/data/scatterd"))
            self.assertEqual(d.stop(), 0)


    def test_a_data_directory_of_everybody_is_complained_of(self):
        with tempfile.TemporaryDirectory() as home:
            os.chmod(home, 0o777)
            d = daemon.Daemon("--data-dir", home)
            d.wait_for_log("event=store .*everybody on this machine may write in")
            self.assertEqual(d.stop(), 0)


class Run(unittest.TestCase):

    def setUp(self):
        self.place = tempfile.TemporaryDirectory()
        self.addCleanup(self.place.cleanup)

    def write(self, name, text):
        path = os.path.join(self.place.name, name)
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        return path

    def test_result(self):
        path = self.write("request.json", '{"a":1}')
        done = run("run", path)
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, '{"a":1}', ""))

    def test_standard_input_and_output_file(self):
        out = os.path.join(self.place.name, "out.cbor")
        done = run("run", "--process", "echo", "-o", out, "-", input="x" * 200000)
        self.assertEqual((done.returncode, done.stdout), (0, ""))
        with open(out, encoding="utf-8") as file:
            self.assertEqual(file.read(), "x" * 200000)

    def test_problem(self):
        out = os.path.join(self.place.name, "out.json")
        done = run("run", "-o", out, self.write("request.json", "problem"))
        self.assertEqual((done.returncode, done.stdout), (1, ""))
        self.assertIn("singular", done.stderr)
        self.assertFalse(os.path.exists(out))

    def test_mistakes(self):
        path = self.write("request.json", "x")
        for words in (["run"], ["run", "a", "b"], ["run", path + "x"], ["run", "--nothing", path],
                      ["run", "-o", "/does/not/exist", path]):
            done = run(*words)
            self.assertEqual(done.returncode, 2, words)
            self.assertTrue(done.stderr)


if __name__ == "__main__":
    unittest.main()
