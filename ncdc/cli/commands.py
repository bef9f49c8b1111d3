"""Names of all commands, and a line on each: nothing here takes time to import."""

__all__ = ["COMMANDS", "EXTRAS", "LATE"]

# Each has a module of its name in this package with EXAMPLE, add_arguments(parser) and run(args);
# run returns the exit status, None for 0.
COMMANDS = {
    "demo": "photo, calibration, training, Verilog, simulation and report on the built-in example",
    "doctor": "what is installed and what is missing, for which purpose, with the line to type",
    "target": "write a page of a calibration target, true to scale, to be printed",
    "calibrate": "find a target's points in photos of it",
    "train": "train a camera's network and write its descriptor",
    "evaluate": "measure the error of a descriptor",
    "lot": "a production lot: calibrate, train and judge every unit, on one machine or several",
    "eeprom": "the image of a camera's EEPROM: show it, write it, make a descriptor of it",
    "report": "write one page of HTML on a camera: pictures, errors, lens, hardware",
    "correct": "correct an image with the bit-exact golden model",
    "export": "write a map as tables for OpenCV's remap, or points as CSV",
    "plan": "choose cache, split and strips for a trained map, and predict its speed on a memory",
    "generate": "write the Verilog of the corrector and its drivers",
    "build": "make the bitstream of a board, or its Quartus project",
    "simulate": "run the generated Verilog on an image and compare every pixel with the golden "
                "model",
    "bench": "measure the figures of the documentation again",
    "sensor": "register writes that set up an image sensor: window, exposure, gain, frame rate",
    "device": "an emulated device on the network: sensor, correction by the golden model, both "
              "protocols",
    "client": "devices on the network: find, show and set their features, grab pictures",
    "soc": "the whole system in simulation: sensor, corrector, processor and Ethernet",
    "completion": "print the script with which a shell completes commands, options and values",
}

# Extras of the package that a command needs; one that is not listed runs with the base.
EXTRAS = {
    "demo": "calibrate,sim", "target": "calibrate", "calibrate": "calibrate", "train": "calibrate",
    "evaluate": "calibrate", "report": "calibrate,hdl", "lot": "calibrate,lot",
    "export": "calibrate", "plan": "hdl", "generate": "hdl", "build": "boards", "simulate": "sim",
    "bench": "all", "soc": "soc",
}

# A package of a command's extra that it imports only as it runs, if at all: its absence is an
# error before any work.
LATE = {"calibrate": "scipy", "target": "matplotlib", "train": "scipy"}
