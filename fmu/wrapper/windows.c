/* What tirefmu's own Windows binary needs beside the system's libraries, so that no C runtime is packed into it: that
 * of zig is as large as a tire.  No other build takes this file.
 */
#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>

/* Loading and unloading: there is nothing to set up. */
int __stdcall DllMainCRTStartup(void *library, unsigned long reason, void *reserved)
{
    (void) library;
    (void) reason;
    (void) reserved;
    return 1;
}

/* Compilers refer to it where there are floating-point numbers. */
int _fltused = 0;

int vsnprintf(char *text, size_t size, const char *format, va_list arguments)
{
    return __stdio_common_vsprintf(_CRT_INTERNAL_PRINTF_STANDARD_SNPRINTF_BEHAVIOR, text, size, format, NULL, arguments);
}

/* Behind isfinite and its kin. */
int __fpclassify(double x)
{
    const double size = fabs(x);

    if (!(size <= DBL_MAX))
        return x != x ? FP_NAN : FP_INFINITE;
    return size >= DBL_MIN ? FP_NORMAL : size > 0.0 ? FP_SUBNORMAL : FP_ZERO;
}

/* What compilers make of a sine and a cosine; read twice, so that they do not make it of these. */
void sincos(double x, double *sine, double *cosine)
{
    const volatile double angle = x;

    *sine = sin(angle);
    *cosine = cos(angle);
}

/* Called before rax bytes of stack are taken, and changes no register.  The system gives a stack page after page, each
   when the one above it has been touched. */
__asm__(".globl ___chkstk_ms\n"
        "___chkstk_ms:\n"
        "    pushq %rax\n"
        "    pushq %rcx\n"
        "    leaq 24(%rsp), %rcx\n"
        "1:  cmpq $4096, %rax\n"
        "    jb 2f\n"
        "    subq $4096, %rcx\n"
        "    orl $0, (%rcx)\n"
        "    subq $4096, %rax\n"
        "    jmp 1b\n"
        "2:  subq %rax, %rcx\n"
        "    orl $0, (%rcx)\n"
        "    popq %rcx\n"
        "    popq %rax\n"
        "    ret\n");
