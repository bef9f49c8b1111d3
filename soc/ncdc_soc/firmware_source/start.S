/* From reset to main: stack, data, zeroed memory; and where interrupts and exceptions go. */
	.option arch, +zicsr
	.section .start, "ax"
	.globl _start
_start:
	j begin

	/* Where the processor goes at an interrupt, and at an exception, of which there must be
	 * none. Registers that C functions preserve need not be saved. */
	.balign 4
trap:
	addi sp, sp, -64
	sw a0, 0(sp)
	csrr a0, mcause
	bgez a0, exception
	sw a1, 4(sp)
	sw a2, 8(sp)
	sw a3, 12(sp)
	sw a4, 16(sp)
	sw a5, 20(sp)
	sw a6, 24(sp)
	sw a7, 28(sp)
	sw t0, 32(sp)
	sw t1, 36(sp)
	sw t2, 40(sp)
	sw t3, 44(sp)
	sw t4, 48(sp)
	sw t5, 52(sp)
	sw t6, 56(sp)
	sw ra, 60(sp)
	call interrupted
	lw a0, 0(sp)
	lw a1, 4(sp)
	lw a2, 8(sp)
	lw a3, 12(sp)
	lw a4, 16(sp)
	lw a5, 20(sp)
	lw a6, 24(sp)
	lw a7, 28(sp)
	lw t0, 32(sp)
	lw t1, 36(sp)
	lw t2, 40(sp)
	lw t3, 44(sp)
	lw t4, 48(sp)
	lw t5, 52(sp)
	lw t6, 56(sp)
	lw ra, 60(sp)
	addi sp, sp, 64
	mret
exception:
	la sp, stack_end
	csrr a0, mcause
	csrr a1, mepc
	call trapped
0:	j 0b

begin:
	la sp, stack_end
	la a0, trap
	csrw mtvec, a0
	la a0, data_begin
	la a1, data_end
	la a2, data_image
1:	bgeu a0, a1, 2f
	lw a3, 0(a2)
	sw a3, 0(a0)
	addi a0, a0, 4
	addi a2, a2, 4
	j 1b
2:	la a0, bss_begin
	la a1, bss_end
3:	bgeu a0, a1, 4f
	sw zero, 0(a0)
	addi a0, a0, 4
	j 3b
4:	call main
5:	j 5b

	/* The first argument is VexRiscv's mask of its lines. */
	.globl interrupts_let
interrupts_let:
	csrw 0xbc0, a0
	li a0, 0x800			/* external ones */
	csrs mie, a0
	csrsi mstatus, 8
	ret
