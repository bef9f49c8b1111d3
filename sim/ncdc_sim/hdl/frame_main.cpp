// Drives the clock of the frame bench under Verilator: a loop in C++ needs no event queue, and no
// compiler support for coroutines.

#include <memory>

#include "Vframe_bench.h"
#include "verilated.h"
#if VM_COVERAGE
#include "verilated_cov.h"
#endif

int main(int argc, char** argv) {
    const auto context = std::make_unique<VerilatedContext>();
    context->commandArgs(argc, argv);
    const auto bench = std::make_unique<Vframe_bench>(context.get());
    while (!context->gotFinish()) {
        bench->clk = !bench->clk;
        bench->eval();
        context->timeInc(5000);
    }
    bench->final();
#if VM_COVERAGE
    context->coveragep()->write("coverage.dat");
#endif
    return 0;
}
