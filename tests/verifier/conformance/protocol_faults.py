"""Programs that answer rightly but break the protocol, one fault each: ``... NAME SOUND FILE``.

The first SOUND requests are answered without the fault. FILE has the answers, by the line that asks for them:
a program that loads no library is there at once, however busy the machine is. Without FILE they are computed.
"""

import json
import os
import subprocess
import sys
import time
from pathlib import Path


def answer(line: str) -> dict[str, object]:
    from convexperc import ConvexpercError, Problem, solve  # noqa: PLC0415 - most programs load no library

    try:
        data = json.loads(line)
    except ValueError:
        return {"id": None, "error": "no JSON"}
    try:
        keys = "X", "o", "modalities", "lambda1", "lambda2", "lambda3", "n", "d"
        X, o, modalities, one, two, three, n, d = (data[key] for key in keys)
        problem = Problem(X, o, modalities=modalities, lambda1=one, lambda2=two, lambda3=three)
        if (n, d) != (problem.n, problem.d) or line.count('"lambda2"') > 1:
            return {"id": data["id"], "error": "n, d, or a key twice"}
        found = solve(problem)
    except (ConvexpercError, KeyError, TypeError) as error:
        return {"id": data["id"] if isinstance(data, dict) else None, "error": str(error)}
    return {"id": data["id"], "w": found.w.tolist(), "u": found.u.tolist(), "objective": found.value}


def say(text: str) -> None:
    sys.stdout.write(text)
    sys.stdout.flush()


def main(name: str, sound: str, *file: str) -> None:  # noqa: C901, PLR0912, PLR0915 - one branch a fault
    stored = json.loads(Path(*file).read_text()) if file else None
    if name == "never reads":
        time.sleep(3600)
    if name == "does not start":
        sys.exit("no licence")
    if name == "banner":
        say("Solver 1.0, all rights reserved\n")
    last, buffered = "", []
    for k, line in enumerate(sys.stdin):
        found = answer(line) if stored is None else stored[line.strip()]
        text = json.dumps(found)
        if k < int(sound):
            pass
        elif "error" in found:
            if name == "silent on malformed":
                continue
            if name == "ends on malformed":
                sys.exit(4)
            if name == "answers malformed":
                text = json.dumps({"id": found["id"], "w": [0.0], "u": [0.0]})
        elif name in CHANGES:
            text = json.dumps(CHANGES[name](dict(found)))
        elif name == "debug lines":
            say("iteration 1\n")
        elif name == "hangs":
            time.sleep(3600)
        elif name == "crashes":
            os.abort()
        elif name == "ends after each":
            say(text + "\n")
            sys.exit(0)
        elif name == "ends before it answers":
            sys.exit(3)
        elif name == "talks after it answers":
            text += "\nbye"
        elif name == "crashes after it answers":
            say(text + "\n")
            time.sleep(0.2)
            os.abort()
        elif name == "answers twice":
            text = f"{text}\n{text}"
        elif name == "one answer late":
            text, last = last or json.dumps({"id": "first"}), text
        elif name == "not flushed":
            buffered.append(text)
            continue
        elif name == "huge output":
            text = '{"id": "' + "x" * (1 << 25)
        elif name == "no end of line":
            say(text)
            continue
        elif name == "not UTF-8":
            sys.stdout.buffer.write(b"\xff\xfe{}\n")
        elif name == "two objects in a line":
            text = f"{text} {text}"
        elif name == "closes its output":
            os.close(1)
            time.sleep(3600)
        elif name == "key twice":
            text = text[:-1] + ', "w": [0.0]}'
        elif name == "a list":
            text = json.dumps([found])
        elif name == "endless lines":
            say("still working\n" * 2000)
            time.sleep(3600)
        elif name == "flood":
            while True:
                say('{"id":"x"}\n' * 1000)
        elif name == "blank lines":
            text = f"\n{text}\n\n"
        elif name == "does not end":
            subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)"])
            say(text + "\n")
            sys.exit(0)
        elif name == "ends later":
            say(text + "\n")
            os.close(0)
            os.close(1)
            time.sleep(0.5)
            os._exit(0)

        say(text + "\n")


CHANGES = {
    "wrong id": lambda found: found | {"id": "someone else"},
    "no id": lambda found: {key: each for key, each in found.items() if key != "id"},
    "no u": lambda found: {key: each for key, each in found.items() if key != "u"},
    "too many weights": lambda found: found | {"w": [*found["w"], 0.0]},
    "NaN": lambda found: found | {"w": [float("nan") for _ in found["w"]]},
    "infinity": lambda found: found | {"objective": float("inf")},
    "numbers as words": lambda found: found | {"w": [str(x) for x in found["w"]]},
    "nested": lambda found: found | {"w": [found["w"]]},
    "keys beyond": lambda found: found | {"iterations": 17, "error": None, "trace": None},
    "error for everything": lambda found: {"id": found["id"], "error": "not today"},
    "error without a reason": lambda found: {"id": found["id"], "error": ""},
    "answer and error": lambda found: found | {"error": "inaccurate"},
}

if __name__ == "__main__":
    main(*sys.argv[1:])
