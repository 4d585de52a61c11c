/** Expressions of fields, as the daemon reads them, for pictures of velocity and exact solution.
 *  What is refused here may still be good there: then the page does without the picture. */

export type Compiled = (values: Record<string, number>) => number;

type Binary = (a: number, b: number) => number;

/** Binary operators by precedence, loosest first. */
const levels: Record<string, Binary>[] = [
  { '||': (a, b) => +(a !== 0 || b !== 0) },
  { '&&': (a, b) => +(a !== 0 && b !== 0) },
  { '==': (a, b) => +(a === b), '!=': (a, b) => +(a !== b) },
  { '<=': (a, b) => +(a <= b), '>=': (a, b) => +(a >= b), '<': (a, b) => +(a < b), '>': (a, b) => +(a > b) },
  { '+': (a, b) => a + b, '-': (a, b) => a - b },
  { '*': (a, b) => a * b, '/': (a, b) => a / b },
];

const names = [
  'sin cos tan asin acos atan sinh cosh tanh asinh acosh atanh exp expm1 log log10 log2 log1p',
  'sqrt cbrt abs floor ceil trunc sign atan2 pow hypot min max',
].join(' ').split(' ');

const functions: Record<string, (...values: number[]) => number> = {
  ...Object.fromEntries(names.map((name) => [name, (Math as never)[name]])),
  ln: Math.log,
  exp2: (x) => 2 ** x,
  round: (x) => Math.sign(x) * Math.round(Math.abs(x)),
  step: (x) => +(x >= 0),
  fmod: (a, b) => a % b,
};

const token = /\s*(?:([0-9]*\.?[0-9]+(?:[eE][-+]?[0-9]+)?|[0-9]+\.)|([A-Za-z_][A-Za-z_0-9]*)|(\|\||&&|[<>=!]=|[-+*/^()<>?:,]))/y;

class Parser {
  private at = 0;
  private next: string | undefined;
  private kind: 'number' | 'name' | 'sign' | 'end' = 'end';

  constructor(private readonly text: string) {
    this.advance();
  }

  whole(): Compiled {
    const value = this.choice();
    if (this.kind !== 'end') throw new SyntaxError(`unexpected ${this.next}`);
    return value;
  }

  private advance(): string | undefined {
    const taken = this.next;
    token.lastIndex = this.at;
    const found = token.exec(this.text);
    if (!found && this.text.slice(this.at).trim()) throw new SyntaxError(`unknown character at ${this.at + 1}`);
    this.at = found ? token.lastIndex : this.text.length;
    this.next = found?.[1] ?? found?.[2] ?? found?.[3];
    this.kind = !found ? 'end' : found[1] ? 'number' : found[2] ? 'name' : 'sign';
    return taken;
  }

  private takes(sign: string): boolean {
    const fits = this.kind === 'sign' && this.next === sign;
    if (fits) this.advance();
    return fits;
  }

  private needs(sign: string): void {
    if (!this.takes(sign)) throw new SyntaxError(`${sign} expected`);
  }

  private choice(): Compiled {
    const condition = this.level(0);
    if (!this.takes('?')) return condition;
    const yes = this.choice();
    this.needs(':');
    const no = this.choice();
    return (v) => (condition(v) !== 0 ? yes(v) : no(v));
  }

  private level(k: number): Compiled {
    const operators = levels[k];
    if (!operators) return this.unary();
    let left = this.level(k + 1);
    while (this.kind === 'sign' && this.next! in operators) {
      const apply = operators[this.advance()!]!;
      const [first, second] = [left, this.level(k + 1)];
      left = (v) => apply(first(v), second(v));
    }
    return left;
  }

  private unary(): Compiled {
    if (this.takes('+')) return this.unary();
    if (!this.takes('-')) return this.power();
    const value = this.unary();
    return (v) => -value(v);
  }

  private power(): Compiled {
    const base = this.atom();
    if (!this.takes('^')) return base;
    const exponent = this.unary();
    return (v) => base(v) ** exponent(v);
  }

  private atom(): Compiled {
    if (this.takes('(')) {
      const inner = this.choice();
      this.needs(')');
      return inner;
    }
    if (this.kind === 'number') {
      const value = Number(this.advance());
      return () => value;
    }
    if (this.kind !== 'name') throw new SyntaxError(`a value is expected before ${this.next ?? 'the end'}`);
    const name = this.advance()!;
    return this.takes('(') ? this.call(name) : variable(name);
  }

  private call(name: string): Compiled {
    const apply = functions[name];
    if (!apply) throw new SyntaxError(`unknown function ${name}`);
    const given = [this.choice()];
    while (this.takes(',')) given.push(this.choice());
    this.needs(')');
    return (v) => apply(...given.map((argument) => argument(v)));
  }
}

function variable(name: string): Compiled {
  if (name === 'pi') return () => Math.PI;
  return (values) => {
    const value = values[name];
    if (value === undefined) throw new SyntaxError(`unknown name ${name}`);
    return value;
  };
}

export function compile(text: string): Compiled {
  return new Parser(text).whole();
}
