"""The words of a network in memories, as the registers write them."""

__all__ = ["bank_words", "take_bank", "write_bank", "write_word"]


def bank_words(hidden_weights, hidden_biases, output_weights):
    """(position, word) of all words that may lie in memories; without a layer that is empty."""
    for j, (weights, bias) in enumerate(zip(hidden_weights, hidden_biases)):
        for role, word in enumerate((*weights, bias)):
            yield {"role": role, "neuron": j, "output": 0}, int(word)
    for role, weights in enumerate(output_weights):
        for j, word in enumerate(weights):
            yield {"role": role, "neuron": j, "output": 1}, int(word)


def write_word(ctx, writes, words):
    """Write the next of the iterator ``words`` in the next clock, to the bank that no frame uses;
    whether there was one left."""
    position, word = next(words, (None, None))
    ctx.set(writes.write, position is not None)
    if position is not None:
        ctx.set(writes.position, position)
        ctx.set(writes.word, word)
        ctx.set(writes.bank, 1 - ctx.get(writes.active))
    return position is not None


async def write_bank(ctx, writes, words):
    """Write all of ``words``, a clock each."""
    while write_word(ctx, writes, words):
        await ctx.tick()


def take_bank(ctx, writes):
    """Let frames use the bank that was written."""
    ctx.set(writes.active, 1 - ctx.get(writes.active))
