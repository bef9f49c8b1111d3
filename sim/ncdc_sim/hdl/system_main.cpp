// Drives the two clocks of the system bench under Verilator, each with its own period: plusargs
// clk_period and extclk_period in ps, extclk_phase in ps for the first edge of the latter.

#include <cstdlib>
#include <cstring>
#include <memory>

#include "Vsystem_bench.h"
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

static const char* text(int argc, char** argv, const char* name, const char* otherwise) {
    for (int k = 1; k < argc; ++k)
        if (!strncmp(argv[k], name, strlen(name))) return argv[k] + strlen(name);
    return otherwise;
}

static uint64_t number(int argc, char** argv, const char* name, uint64_t otherwise) {
    const char* given = text(argc, argv, name, nullptr);
    return given ? strtoull(given, nullptr, 10) : otherwise;
}

int main(int argc, char** argv) {
    const auto context = std::make_unique<VerilatedContext>();
    context->commandArgs(argc, argv);
    const uint64_t half = number(argc, argv, "+clk_period=", 10000) / 2;
    const uint64_t other_half = number(argc, argv, "+extclk_period=", 10000) / 2;
    uint64_t next = half, other = number(argc, argv, "+extclk_phase=", other_half);
    const auto bench = std::make_unique<Vsystem_bench>(context.get());
#if VM_TRACE
    // Of a build for waveforms, which writes them if the plusarg names a file.
    context->traceEverOn(true);
    Waves waves;
    bench->trace(&waves, 99);
    waves.open(text(argc, argv, "+waves=", "/dev/null"));
#endif
    while (!context->gotFinish()) {
        const uint64_t now = next < other ? next : other;
        context->time(now);
        if (now == next) {
            bench->clk = !bench->clk;
            next += half;
        }
        if (now == other) {
            bench->extclk = !bench->extclk;
            other += other_half;
        }
        bench->eval();
#if VM_TRACE
        waves.dump(context->time());
#endif
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
