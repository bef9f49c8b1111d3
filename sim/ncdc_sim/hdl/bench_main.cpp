// Drives the clocks of a bench under Verilator: a loop in C++ needs no event queue, and no compiler
// support for coroutines.
//
// Every input called clk, extclk, lane, line or pixel is a clock. Plusargs, in ps: <clock>_period, 10000
// without it, 0 if it stands still; <clock>_phase, the time of its first edge, half a period without it.

#include <cstdlib>
#include <cstring>
#include <memory>
#include <vector>

#include "Vbench.h"
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

struct Clock {
    CData* pin;
    uint64_t half, next;
};

static const char* text(int argc, char** argv, const char* name, const char* otherwise) {
    for (int k = 1; k < argc; ++k)
        if (!strncmp(argv[k], name, strlen(name))) return argv[k] + strlen(name);
    return otherwise;
}

static uint64_t number(int argc, char** argv, const char* name, uint64_t otherwise) {
    const char* given = text(argc, argv, name, nullptr);
    return given ? strtoull(given, nullptr, 10) : otherwise;
}

// The input of that name, or none if the bench has none.
#define INPUT(name) \
    template <class Bench> static CData* name(Bench& bench, decltype(&bench.name)) { return &bench.name; } \
    template <class Bench> static CData* name(Bench&, ...) { return nullptr; }
struct Inputs {
    INPUT(clk)
    INPUT(extclk)
    INPUT(lane)
    INPUT(line)
    INPUT(pixel)
};

int main(int argc, char** argv) {
    const auto context = std::make_unique<VerilatedContext>();
    context->commandArgs(argc, argv);
    const auto bench = std::make_unique<Vbench>(context.get());
    std::vector<Clock> clocks;
#define CLOCK(name) \
    if (const uint64_t half = number(argc, argv, "+" #name "_period=", 10000) / 2) \
        if (CData* const pin = Inputs::name(*bench, nullptr)) \
            clocks.push_back({pin, half, number(argc, argv, "+" #name "_phase=", half)});
    CLOCK(clk)
    CLOCK(extclk)
    CLOCK(lane)
    CLOCK(line)
    CLOCK(pixel)
#if VM_TRACE
    // Of a build for waveforms, which writes them if the plusarg names a file.
    context->traceEverOn(true);
    Waves waves;
    bench->trace(&waves, 99);
    waves.open(text(argc, argv, "+waves=", "/dev/null"));
#endif
    while (!context->gotFinish()) {
        uint64_t now = ~0ull;
        for (const Clock& clock : clocks)
            if (clock.next < now) now = clock.next;
        context->time(now);
        for (Clock& clock : clocks)
            if (clock.next == now) {
                *clock.pin = !*clock.pin;
                clock.next += clock.half;
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
