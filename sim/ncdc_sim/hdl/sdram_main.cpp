// Drives the clock of the SDRAM bench under Verilator: a loop in C++ needs no event queue.

#include <memory>

#include "Vsdram_bench.h"
#include "verilated.h"

int main(int argc, char** argv) {
    const auto context = std::make_unique<VerilatedContext>();
    context->commandArgs(argc, argv);
    const auto bench = std::make_unique<Vsdram_bench>(context.get());
    while (!context->gotFinish()) {
        bench->clk = !bench->clk;
        bench->eval();
        context->timeInc(5000);
    }
    bench->final();
    return 0;
}
