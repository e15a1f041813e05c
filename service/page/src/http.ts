/** One request to the public API: a good reply, or the problem that it was refused with. */

/** Problem document (RFC 9457) of a refused request. */
export interface Problem {
  title: string;
  status: number;
  detail: string;
  code: string;
  context: { field?: string; value?: unknown; allowed?: unknown };
}

export class ProblemError extends Error {
  constructor(readonly problem: Problem) {
    super(problem.detail);
  }
}

export const asProblem = (error: unknown): Problem =>
  error instanceof ProblemError
    ? error.problem
    : { title: "The page failed", status: 0, detail: String(error), code: "page", context: {} };

const UNREACHABLE: Problem = {
  title: "The service does not answer",
  status: 0,
  detail: "The laboratory cannot be reached.",
  code: "unreachable",
  context: {},
};

export async function request(path: string, init: RequestInit = {}): Promise<Response> {
  let reply: Response;
  try {
    reply = await fetch(`v1${path}`, init);
  } catch {
    throw new ProblemError(UNREACHABLE);
  }
  if (!reply.ok) throw new ProblemError(await problemOf(reply));
  return reply;
}

async function problemOf(reply: Response): Promise<Problem> {
  try {
    return (await reply.json()) as Problem;
  } catch {
    return { ...UNREACHABLE, title: "The request failed", status: reply.status, detail: `The reply was ${reply.status}.` };
  }
}

/** Return the request that sends a value as JSON. */
export const posting = (body: unknown): RequestInit => ({
  method: "POST",
  headers: { "Content-Type": "application/json" },
  body: JSON.stringify(body),
});
