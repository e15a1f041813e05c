/** The frame of the page: views as steps of a test, and the light. */

import { useEffect, useRef, useState } from "preact/hooks";
import { Account, SignInForm } from "./parts/sign-in";
import { resume, useSession } from "./session";
import { type State, type View, VIEWS, address, useAddress } from "./state";
import { Loading, ProblemNote } from "./parts/notes";
import { useLoaded } from "./use";
import { RigView } from "./views/rig";

const TITLES: Record<View, string> = {
  rig: "Rig",
  measure: "Measure",
  extract: "Extract",
  correlate: "Correlate",
  diagnose: "Diagnose",
  class: "Class",
};

// The first view comes with the page, the others when they are asked for.
const LATER: Record<Exclude<View, "rig">, () => Promise<ViewComponent>> = {
  measure: () => import("./views/measure").then((views) => views.MeasureView),
  extract: () => import("./views/extract").then((views) => views.ExtractView),
  correlate: () => import("./views/correlate").then((views) => views.CorrelateView),
  diagnose: () => import("./views/diagnose").then((views) => views.DiagnoseView),
  class: () => import("./views/class").then((views) => views.ClassView),
};

type ViewComponent = (props: { state: State }) => preact.JSX.Element;

function LaterView({ view, state }: { view: Exclude<View, "rig">; state: State }) {
  const loaded = useLoaded<{ View: ViewComponent }>(`view/${view}`, async () => ({ View: await LATER[view]() }));
  if (loaded.problem) return <ProblemNote problem={loaded.problem} again={() => location.reload()} />;
  return loaded.value ? <loaded.value.View state={state} /> : <Loading what="the view" />;
}

/** The button of saved work, and the dialog that it opens. */
function Saved() {
  const [open, setOpen] = useState(false);
  const loaded = useLoaded(open ? "saved" : null, async () => ({ Work: (await import("./views/saved")).SavedWork }));
  return (
    <>
      <button type="button" class="quiet" onClick={() => setOpen(true)}>Saved work</button>
      {open && loaded.problem && <ProblemNote problem={loaded.problem} again={() => location.reload()} />}
      {open && loaded.value && <loaded.value.Work close={() => setOpen(false)} />}
    </>
  );
}

export function App() {
  const state = useAddress();
  const session = useSession();
  const before = useRef(state.view);
  useEffect(() => {
    document.title = `${TITLES[state.view]} – modallab`;
    // A link at the end of a view is gone with it: who pressed it goes on at the top of the next one.
    if (before.current !== state.view && document.activeElement === document.body) document.getElementById("main")!.focus();
    before.current = state.view;
  }, [state.view]);
  useEffect(() => {
    resume();
  }, []);
  return (
    <>
      <a class="skip" href="#main" onClick={focusMain}>Skip to the view</a>
      <header class="top">
        <a class="brand" href={address({ ...state, view: "rig" })}>
          <Trace />
          modallab
        </a>
        <Steps state={state} />
        <div class="top-end">
          <Saved />
          <Account session={session} />
          <a class="quiet" href="docs">API</a>
          <LightSwitch />
        </div>
      </header>
      <main id="main" tabIndex={-1} aria-label={TITLES[state.view]}>
        {state.view === "rig" ? <RigView state={state} /> : <LaterView key={state.view} view={state.view} state={state} />}
      </main>
      {session.asking && <SignInForm told={session.told} />}
    </>
  );
}

function focusMain(event: Event) {
  event.preventDefault();
  document.getElementById("main")!.focus();
}

function Trace() {
  return (
    <svg class="trace" viewBox="0 0 32 20" aria-hidden="true">
      <path d="M1 17h8c4 0 4-14 7-14s3 14 7 14h8" />
    </svg>
  );
}

function Steps({ state }: { state: State }) {
  return (
    <nav class="steps" aria-label="Steps of a test">
      {VIEWS.map((view, i) => (
        <a href={address({ ...state, view })} aria-current={view === state.view ? "page" : undefined}>
          <span class="number" aria-hidden="true">{i + 1}</span>
          {TITLES[view]}
        </a>
      ))}
    </nav>
  );
}

const LIGHTS = ["system", "light", "dark"] as const;

function LightSwitch() {
  const [light, setLight] = useState(() => localStorage.getItem("light") ?? "system");
  useEffect(() => {
    if (light === "system") document.documentElement.removeAttribute("data-light");
    else document.documentElement.dataset.light = light;
    localStorage.setItem("light", light);
    dispatchEvent(new Event("lightchange"));
  }, [light]);
  const next = LIGHTS[(LIGHTS.indexOf(light as (typeof LIGHTS)[number]) + 1) % LIGHTS.length];
  return (
    <button type="button" class="quiet" onClick={() => setLight(next)} title={`Colours: ${light}; change to ${next}`}>
      <span class="visually-hidden">Colours: </span>
      {light === "system" ? "Auto" : light === "light" ? "Light" : "Dark"}
    </button>
  );
}
