// Drives the clock of the frame bench under Verilator: a loop in C++ needs no event queue, and no
// compiler support for coroutines.

#include <cstdlib>
#include <cstring>
#include <memory>

#include "Vframe_bench.h"
#include "verilated.h"
#if VM_COVERAGE
#include "verilated_cov.h"
#endif
#if VM_TRACE_FST
#include "verilated_fst_c.h"
using Waves = VerilatedFstC;
#elif VM_TRACE
#include "verilated_vcd_c.h"
using Waves = VerilatedVcdC;
#endif

#if VM_TRACE
static const char* text(int argc, char** argv, const char* name, const char* otherwise) {
    for (int k = 1; k < argc; ++k)
        if (!strncmp(argv[k], name, strlen(name))) return argv[k] + strlen(name);
    return otherwise;
}
#endif

int main(int argc, char** argv) {
    const auto context = std::make_unique<VerilatedContext>();
    context->commandArgs(argc, argv);
    const auto bench = std::make_unique<Vframe_bench>(context.get());
#if VM_TRACE
    // Of a build for waveforms, which writes them if the plusarg names a file.
    context->traceEverOn(true);
    Waves waves;
    bench->trace(&waves, 99);
    waves.open(text(argc, argv, "+waves=", "/dev/null"));
#endif
    while (!context->gotFinish()) {
        bench->clk = !bench->clk;
        bench->eval();
#if VM_TRACE
        waves.dump(context->time());
#endif
        context->timeInc(5000);
    }
    bench->final();
#if VM_TRACE
    waves.close();
#endif
#if VM_COVERAGE
    context->coveragep()->write(getenv("NCDC_COVERAGE"));
#endif
    return 0;
}
